"""The interface of painters, the position of pictures, and lines with pictures as escape sequences."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from rich.segment import ControlType, Segment
from textual.strip import Strip

from graphnav.arrays import Bytes

_SAVE, _RESTORE = "\x1b7", "\x1b8"
"""The cursor's place and colours."""


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


def raw_strips(rows: int, cols: int, cells: Cells, covered: Cells, sequence: str) -> list[Strip]:
    """Return the lines of a view of ``rows`` x ``cols`` cells; ``sequence`` draws on ``cells`` of them.

    The cells of ``covered``, which the picture hides, are skipped and not blanked, to avoid flicker; all others are
    blanked. The sequence is part of the last line, so that later text cannot erase the picture.
    """
    blank = Strip([Segment(" " * cols)], cols)
    strips = [
        blank if not covered.row <= row < covered.row + covered.rows else _passed_over(cols, covered)
        for row in range(rows)
    ]
    to_picture = _move("A", rows - 1 - cells.row) + _move("C", cells.col)
    drawn = _raw(f"{_RESTORE}{to_picture}{sequence}{_RESTORE}")
    strips[-1] = Strip([_raw(_SAVE), *strips[-1], drawn], cols)
    return strips


def _passed_over(cols: int, covered: Cells) -> Strip:
    right = cols - covered.col - covered.cols
    return Strip([Segment(" " * covered.col), _raw(_move("C", covered.cols)), Segment(" " * right)], cols)


def _move(direction: str, count: int) -> str:
    return f"\x1b[{count}{direction}" if count else ""


def _raw(text: str) -> Segment:
    """Return a segment that is written unchanged: Rich gives segments with control codes no width."""
    return Segment(text, None, [(ControlType.CURSOR_FORWARD, 0)])
