"""The fields of a message as lines of a tree: arrays are summarised, and expandable to single numbers."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from graphnav.core.errors import shown_name
from graphnav.core.field_summary import value_text
from graphnav.watch.spy.watch.series import Path

_MAX_CHILDREN = 64
_MAX_LINES = 4000
_MAX_DEPTH = 16


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
