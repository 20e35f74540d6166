"""Pictures by half blocks, which any terminal shows at low cost."""

from __future__ import annotations

import os

from rich.color import Color
from rich.segment import Segment
from rich.style import Style
from textual.strip import Strip

from graphnav.arrays import Bytes
from graphnav.watch.spy.graphics.half_blocks import UPPER_HALF, half_blocks, run_of, shades
from graphnav.watch.spy.screen.painters.painter import Cells, centred

_MAX_SEGMENTS = 50_000


class BlockPainter:
    """Two pixels per cell; characters from dark to bright without colour."""

    is_raw = False

    def __init__(self) -> None:
        self._segments: dict[int, Segment] = {}
        self._has_colour = not os.environ.get("NO_COLOR")

    def box_px(self, rows: int, cols: int) -> tuple[int, int]:
        """Return the number of pixels of a view."""
        return max(1, 2 * rows), max(1, cols)

    def paint(self, picture: Bytes, rows: int, cols: int) -> list[Strip]:
        """Return the lines up to the last line of the picture."""
        if self._has_colour:
            kept = self._segments
            lines = [[kept.get(run) or self._segment(run) for run in line] for line in half_blocks(picture)]
        else:
            lines = [[Segment(line)] for line in shades(picture)]
        cells = self.place(picture, rows, cols)
        margin = [Segment(" " * cells.col)] if cells.col else []
        blank = [Strip([])] * cells.row
        return [*blank, *(Strip([*margin, *line], cells.col + cells.cols) for line in lines)]

    def place(self, picture: Bytes, rows: int, cols: int) -> Cells:
        """Return the cells of the picture."""
        return centred((picture.shape[0] + 1) // 2, picture.shape[1], rows, cols)

    def erase(self) -> str:
        """Return an empty sequence: writing over a picture replaces it."""
        return ""

    def _segment(self, packed: int) -> Segment:
        """Make the segment of a run; cached, because the next picture has similar runs."""
        if len(self._segments) >= _MAX_SEGMENTS:
            self._segments.clear()
        run = run_of(packed)
        style = Style(color=Color.from_rgb(*run.above), bgcolor=Color.from_rgb(*run.below))
        segment = self._segments[packed] = Segment(UPPER_HALF * run.length, style)
        return segment
