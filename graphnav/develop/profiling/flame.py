"""Draw boxes within boxes as a flame graph: the tick on top, below each box what ran within it, widths are times."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from graphnav.core.errors import printable
from graphnav.core.html_templates import rendered

_MIN_WIDTH_PX, _MAX_WIDTH_PX = 1200.0, 12_000.0
_STAGE_PX = 45.0
"""The mean width of a stage: a graph with many gets a wider picture, so that names can be read."""
_ROW_PX = 19.0
_TOP_PX = 62.0
_CHARACTER_PX = 6.6
_PADDING_PX = 4.0
_MIN_BOX_PX = 0.15
"""Narrower boxes cannot be seen."""

COLOURS = {
    "tick": "#d7dce2",
    "stage": "#f4c27a",
    "step": "#ee8f52",
    "function": "#f7d9a8",
    "check": "#b9c0c8",
    "encode": "#8ec6e8",
    "deliver": "#6fb7b0",
    "decode": "#b3a2dd",
    "log": "#9ccb86",
    "tap": "#c9cf78",
}
"""By kind of box."""


@dataclass(frozen=True)
class Node:
    """A box of the flame graph: mean milliseconds of a tick, what is within it included."""

    label: str
    kind: str
    """The part, or ``function``."""
    ms: float
    note: str = ""
    children: tuple[Node, ...] = ()

    def walk(self) -> Iterator[Node]:
        """Yield this box and all within it."""
        yield self
        for child in self.children:
            yield from child.walk()


@dataclass(frozen=True)
class Box:
    """A rectangle of the picture with its label, cut to fit, and its tooltip; pixels."""

    x: float
    y: float
    width: float
    colour: str
    label: str
    tooltip: str


def flame_svg(tree: Node, title: str, note: str) -> str:
    """Return an SVG document with a note below its title; every name in it is escaped."""
    width = min(max(_MIN_WIDTH_PX, _STAGE_PX * len(tree.children)), _MAX_WIDTH_PX)
    scale = width / tree.ms if tree.ms else 0.0
    boxes = list(_boxes(tree, tree.ms, 0.0, _TOP_PX, scale))
    kinds = {node.kind for node in tree.walk()}
    picture = rendered(
        "graphnav.develop.profiling",
        "flame.svg",
        title=printable(title),
        note=note,
        width=width,
        shrinks=width == _MIN_WIDTH_PX,
        height=max(box.y for box in boxes) + _ROW_PX + 8,
        row=_ROW_PX - 1,
        boxes=boxes,
        legend=[(22 + 84 * place, kind, COLOURS[kind]) for place, kind in enumerate(k for k in COLOURS if k in kinds)],
    )
    return picture + "\n"


def _boxes(node: Node, total_ms: float, x: float, y: float, scale: float) -> Iterator[Box]:
    """Yield the boxes of a node and of all within it, from left to right; its own time is the gap at the right."""
    width = node.ms * scale
    if width < _MIN_BOX_PX and total_ms != node.ms:
        return
    label = printable(node.label)
    tooltip = f"{label}: {_time(node.ms)} of a tick, {_share(node.ms, total_ms)}"
    if node.note:
        tooltip += f"\n{printable(node.note)}"
    yield Box(x, y, width, COLOURS[node.kind], _cut(label, width), tooltip)
    for child in node.children:
        yield from _boxes(child, total_ms, x, y + _ROW_PX, scale)
        x += child.ms * scale


def _cut(label: str, width: float) -> str:
    """Return as much of a label as fits; empty if that is less than two characters."""
    n_characters = int((width - 2 * _PADDING_PX) / _CHARACTER_PX)
    if len(label) <= n_characters:
        return label
    return f"{label[: n_characters - 1]}…" if n_characters > 2 else ""


def _time(ms: float) -> str:
    return f"{ms:.3f} ms" if ms >= 0.1 else f"{ms * 1e3:.1f} µs"


def _share(ms: float, total_ms: float) -> str:
    return f"{ms / total_ms:.1%}" if total_ms else "0 %"
