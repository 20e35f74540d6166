"""The tree of a message's fields."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from rich.segment import Segment
from rich.style import Style

from graphnav.core.errors import shown_name
from graphnav.core.field_summary import value_text
from graphnav.watch.spy.screen.columns import fitted
from graphnav.watch.spy.screen.line_list import HEADING, PLAIN, QUIET, Line, Lines
from graphnav.watch.spy.series import Path

_MAX_CHILDREN = 64
_MAX_LINES = 4000
_MAX_DEPTH = 16
_NAME = Style(color="cyan")
_PLOTTED = Style(color="green", bold=True)
_INDENT = 2
_MAX_NAME = 24


class FieldLine(NamedTuple):
    """A line of the tree; ``is_open`` is None for leaves."""

    path: Path
    depth: int
    name: str
    text: str
    is_open: bool | None
    is_number: bool


def field_lines(values: Mapping[str, Any], opened: Collection[Path]) -> list[FieldLine]:
    """Return the lines of a message with ``opened`` paths expanded, at most 4000."""
    lines: list[FieldLine] = []
    for line in _lines(values, (), opened):
        if len(lines) == _MAX_LINES:
            break
        lines.append(line)
    return lines


def _lines(value: Any, path: Path, opened: Collection[Path]) -> Iterator[FieldLine]:
    depth = len(path)
    for key, item in _children(value):
        below = (*path, key)
        can_open = _size(item) > 0 and depth < _MAX_DEPTH
        is_open = below in opened if can_open else None
        name = f"[{key}]" if isinstance(key, int) else shown_name(key)
        text = "" if isinstance(item, Mapping) else shown_name(value_text(str(key), item))
        yield FieldLine(below, depth, name, text, is_open, _is_number(item))
        if is_open:
            yield from _lines(item, below, opened)
            left = _size(item) - _MAX_CHILDREN
            if left > 0:
                yield FieldLine((*below, -1), depth + 1, "", f"{left} more", None, is_number=False)


def _children(value: Any) -> Iterator[tuple[str | int, Any]]:
    if isinstance(value, Mapping):
        yield from value.items()
        return
    for index in range(min(len(value), _MAX_CHILDREN)):
        item = value[index]
        yield index, item.item() if isinstance(item, np.generic) else item


def _size(value: Any) -> int:
    """Return the number of children of a value."""
    if isinstance(value, np.ndarray):
        return len(value) if value.ndim else 0
    return len(value) if isinstance(value, Mapping | tuple) else 0


def _is_number(value: Any) -> bool:
    return isinstance(value, bool | int | float)


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
