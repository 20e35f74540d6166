"""What a painter of pictures has to do, and where a picture lies."""

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
    """Turns pictures into strips, one for each line of a view; one painter for a view.

    ``is_raw``: the strips hold escape sequences, which must reach the terminal as they are.
    """

    is_raw: bool

    def box_px(self, rows: int, cols: int) -> tuple[int, int]:
        """Return the rows and columns of pixels that a picture for a view of so many cells may have."""

    def paint(self, picture: Bytes, rows: int, cols: int) -> list[Strip]:
        """Return the lines of a view with a picture (rows, cols, 3), no larger than its box, in its middle."""

    def place(self, picture: Bytes, rows: int, cols: int) -> Cells:
        """Return the cells of the view that the picture takes."""

    def erase(self) -> str:
        """Return the sequence that takes away what writing over its cells does not; empty where there is nothing."""


def centred(picture_rows: int, picture_cols: int, rows: int, cols: int) -> Cells:
    """Return the cells in the middle of a view."""
    return Cells(max(0, rows - picture_rows) // 2, max(0, cols - picture_cols) // 2, picture_rows, picture_cols)
