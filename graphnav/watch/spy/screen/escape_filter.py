"""Escape what widgets show, before it is sent to the terminal."""

from __future__ import annotations

from rich.cells import cell_len, set_cell_size
from rich.segment import Segment
from textual.color import Color
from textual.filter import LineFilter

from graphnav.core.errors import printable


class EscapeFilter(LineFilter):
    """Escapes the text of a line and keeps its width; pictures as escape sequences do not pass through filters."""

    def apply(self, segments: list[Segment], background: Color) -> list[Segment]:
        """Return the segments of a line."""
        del background
        return [segment if segment.control else _escaped(segment) for segment in segments]


def _escaped(segment: Segment) -> Segment:
    text = printable(segment.text)
    if text == segment.text:
        return segment
    return Segment(set_cell_size(text, cell_len(segment.text)), segment.style)
