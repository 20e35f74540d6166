"""Lines of a view with a picture as escape sequences."""

from __future__ import annotations

from rich.segment import ControlType, Segment
from textual.strip import Strip

from graphnav.watch.spy.screen.painters.painter import Cells

_SAVE, _RESTORE = "\x1b7", "\x1b8"
"""The cursor's place and colours."""


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
