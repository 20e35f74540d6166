"""The interface of painters, and the position of pictures."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from textual.strip import Strip

from graphnav.arrays import Bytes


class Cells(NamedTuple):
    """A rectangle of cells within a view: the row and column of its upper left one, and its size."""

    row: int
    col: int
    rows: int
    cols: int


class Painter(Protocol):
    """Converts pictures to strips, one per line of a view; each view has its own painter.

    ``is_raw``: the strips hold escape sequences, which must reach the terminal unchanged.
    """

    is_raw: bool

    def box_px(self, rows: int, cols: int) -> tuple[int, int]:
        """Return the maximum rows and columns of pixels of a picture for a view of this size in cells."""

    def paint(self, picture: Bytes, rows: int, cols: int) -> list[Strip]:
        """Return the lines of a view with a picture (rows, cols, 3), at most of size ``box_px``, in its centre."""

    def place(self, picture: Bytes, rows: int, cols: int) -> Cells:
        """Return the cells of the view that the picture covers."""

    def erase(self) -> str:
        """Return the sequence that removes a picture that overwriting its cells does not; else an empty string."""


def centred(picture_rows: int, picture_cols: int, rows: int, cols: int) -> Cells:
    """Return the cells in the centre of a view."""
    return Cells(max(0, rows - picture_rows) // 2, max(0, cols - picture_cols) // 2, picture_rows, picture_cols)
