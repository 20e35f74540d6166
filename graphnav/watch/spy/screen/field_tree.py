"""The tree of a message's fields."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from rich.segment import Segment
from rich.style import Style

from graphnav.watch.spy.field_lines import FieldLine, field_lines
from graphnav.watch.spy.screen.columns import fitted
from graphnav.watch.spy.screen.line_list import HEADING, PLAIN, QUIET, Line, Lines
from graphnav.watch.spy.watch.series import Path

_NAME = Style(color="cyan")
_PLOTTED = Style(color="green", bold=True)
_INDENT = 2
_MAX_NAME = 24


class FieldTree(Lines):
    """The fields of the newest message; fields stay expanded from message to message."""

    def __init__(self, *, id: str | None = None) -> None:  # noqa: A002, Textual's name
        super().__init__(id=id)
        self._values: Mapping[str, Any] = {}
        self._opened: set[Path] = set()
        self._plotted: Collection[Path] = ()
        self._fields: list[FieldLine] = []

    @property
    def chosen(self) -> FieldLine | None:
        """The field at the cursor."""
        return self._fields[self.cursor] if self.cursor < len(self._fields) else None

    def show(self, values: Mapping[str, Any], plotted: Collection[Path]) -> None:
        """Show a message, with marks at plotted fields."""
        self._values, self._plotted = values, plotted
        self._draw()

    def toggle(self) -> None:
        """Expand the field at the cursor, or collapse it."""
        field = self.chosen
        if field is not None and field.is_open is not None:
            self._opened ^= {field.path}
            self._draw()

    def on_resize(self) -> None:
        """Redraw in the new width."""
        self._draw()

    def _draw(self) -> None:
        chosen = self.chosen
        self._fields = field_lines(self._values, self._opened)
        paths = [field.path for field in self._fields]
        cursor = paths.index(chosen.path) if chosen and chosen.path in paths else self.cursor
        width = min(_MAX_NAME, max((_INDENT * f.depth + len(f.name) for f in self._fields), default=0))
        lines = [self._line(field, width) for field in self._fields]
        self.show_lines([Segment("fields", HEADING)], lines, max(0, min(cursor, len(lines) - 1)))

    def _line(self, field: FieldLine, width: int) -> Line:
        sign = " " if field.is_open is None else "▾" if field.is_open else "▸"
        is_plotted = field.path in self._plotted
        name = fitted(" " * (_INDENT * field.depth) + field.name, width, is_left=True)
        text = fitted(field.text, max(0, self.size.width - width - 4), is_left=True)
        mark = Segment("•" if is_plotted else " ", _PLOTTED)
        return [Segment(sign, QUIET), mark, Segment(name + "  ", _NAME), Segment(text, PLAIN)]
