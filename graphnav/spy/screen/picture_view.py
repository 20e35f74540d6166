"""A picture in the terminal, by half blocks: any terminal shows them, and they cost little."""

from __future__ import annotations

import os

import numpy as np
import numpy.typing as npt
from rich.color import Color
from rich.segment import Segment
from rich.style import Style
from textual.strip import Strip
from textual.widget import Widget

from graphnav.spy.half_blocks import UPPER_HALF, half_blocks, run_of, shades

Bytes = npt.NDArray[np.uint8]

_MAX_SEGMENTS = 50_000


class PictureView(Widget):
    """Shows a picture in its middle, or why there is none."""

    def __init__(self, *, id: str | None = None) -> None:  # noqa: A002, Textual's name
        super().__init__(id=id)
        self._strips: list[Strip] = []
        self._segments: dict[int, Segment] = {}
        self._has_colour = not os.environ.get("NO_COLOR")

    @property
    def box_px(self) -> tuple[int, int]:
        """Rows and columns of pixels that there is room for."""
        return max(1, 2 * self.size.height), max(1, self.size.width)

    def show(self, picture: Bytes) -> None:
        """Show a picture (rows, cols, 3) that fits the box."""
        if self._has_colour:
            kept = self._segments
            lines = [[kept.get(run) or self._segment(run) for run in line] for line in half_blocks(picture)]
        else:
            lines = [[Segment(line)] for line in shades(picture)]
        left = (self.size.width - picture.shape[1]) // 2
        above = (self.size.height - len(lines)) // 2
        margin = [Segment(" " * left)] if left > 0 else []
        blank = [Strip([])] * max(0, above)
        self._strips = [*blank, *(Strip([*margin, *line], left + picture.shape[1]) for line in lines)]
        self.refresh()

    def say(self, text: str) -> None:
        """Show a text in place of a picture."""
        strips = [Strip([Segment(line)]) for line in text.splitlines()]
        if strips != self._strips:
            self._strips = strips
            self.refresh()

    def render_line(self, y: int) -> Strip:
        """Return a line of the picture."""
        return self._strips[y] if y < len(self._strips) else Strip([])

    def _segment(self, packed: int) -> Segment:
        """Make the segment of a run and keep it: the next picture has the same ones."""
        if len(self._segments) >= _MAX_SEGMENTS:
            self._segments.clear()
        run = run_of(packed)
        style = Style(color=Color.from_rgb(*run.above), bgcolor=Color.from_rgb(*run.below))
        segment = self._segments[packed] = Segment(UPPER_HALF * run.length, style)
        return segment
