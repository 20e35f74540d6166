"""Arrange the boxes of a graph in columns, so that wires run to the right with few crossings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from graphnav.core.render.boxes import Box, Wire, wires_of

_SWEEPS = 12


@dataclass
class Spot:
    """A box's place in a column, or that of a wire that passes through it (``box`` is empty)."""

    box: str
    column: int
    height: float
    top: float = 0.0
    left: list[Spot] = field(default_factory=list)
    right: list[Spot] = field(default_factory=list)

    @property
    def middle(self) -> float:
        """The y coordinate of the centre."""
        return self.top + self.height / 2


@dataclass
class Route:
    """The spots that a wire passes on its way to the right; empty for a wire that runs back."""

    wire: Wire
    passes: list[Spot]
    runs_back: bool


@dataclass
class Layers:
    """Columns of spots, from the sources to the sinks, and the routes of the wires."""

    columns: list[list[Spot]]
    spots: dict[str, Spot]
    routes: list[Route]


def layers_of(boxes: Sequence[Box], heights: dict[str, float], gap: float) -> Layers:
    """Return boxes in columns by data flow depth, each column stacked from the top.

    ``heights``: of each of the ``boxes``; ``gap``: between two in a column.
    """
    wires = wires_of(boxes)
    depth = _depths(boxes, wires)
    spots = {box.key: Spot(box.key, depth[box.key], heights[box.key]) for box in boxes}
    columns: list[list[Spot]] = [[] for _ in range(max(depth.values()) + 1)]
    for spot in spots.values():
        columns[spot.column].append(spot)
    routes = [_route(wire, spots, columns) for wire in wires]
    for number in range(_SWEEPS):
        for column in columns if number % 2 == 0 else reversed(columns):
            _order(column, by_left=number % 2 == 0)
        _stack(columns, gap)
    for number in range(_SWEEPS):
        for column in columns if number % 2 else reversed(columns):
            _settle(column, gap)
    lowest = min(spot.top for column in columns for spot in column)
    for column in columns:
        for spot in column:
            spot.top -= lowest
    return Layers(columns, spots, routes)


def _depths(boxes: Sequence[Box], wires: Sequence[Wire]) -> dict[str, int]:
    """Return the column of each box; a cycle of plain wires, which no checked graph has, is cut at its closing wire."""
    by_key = {box.key: box for box in boxes}
    writers: dict[str, list[str]] = {box.key: [] for box in boxes}
    for wire in wires:
        if not wire.latest:
            writers[wire.reader].append(wire.channel.stage)
    depth: dict[str, int] = {}
    under_way: set[str] = set()

    def depth_of(key: str) -> int:
        if key not in depth:
            under_way.add(key)
            before = [depth_of(writer) for writer in writers[key] if writer not in under_way]
            under_way.remove(key)
            depth[key] = 1 + max(before, default=0) if by_key[key].kind in ("stage", "output") else 0
        return depth[key]

    return {box.key: depth_of(box.key) for box in boxes}


def _route(wire: Wire, spots: dict[str, Spot], columns: list[list[Spot]]) -> Route:
    start, end = spots[wire.channel.stage], spots[wire.reader]
    if end.column <= start.column:
        return Route(wire, [], runs_back=True)
    passes = [Spot("", column, 0.0) for column in range(start.column + 1, end.column)]
    for spot in passes:
        columns[spot.column].append(spot)
    chain = [start, *passes, end]
    for one, next_one in pairwise(chain):
        one.right.append(next_one)
        next_one.left.append(one)
    return Route(wire, passes, runs_back=False)


def _order(column: list[Spot], *, by_left: bool) -> None:
    """Sort a column by the mean height of its neighbours on one side."""

    def wanted(spot: Spot) -> float:
        neighbours = spot.left if by_left else spot.right
        return sum(n.middle for n in neighbours) / len(neighbours) if neighbours else spot.middle

    column.sort(key=wanted)


def _stack(columns: list[list[Spot]], gap: float) -> None:
    for column in columns:
        top = 0.0
        for spot in column:
            spot.top = top
            top += spot.height + gap


def _settle(column: list[Spot], gap: float) -> None:
    """Move the spots of a column towards their neighbours, keeping order and gaps."""
    wanted = []
    for spot in column:
        neighbours = spot.left + spot.right
        middle = sum(n.middle for n in neighbours) / len(neighbours) if neighbours else spot.middle
        wanted.append(middle - spot.height / 2)
    down, top = [], -1e9
    for spot, want in zip(column, wanted, strict=True):
        down.append(max(want, top))
        top = down[-1] + spot.height + gap
    up, bottom = [], 1e9
    for spot, want in zip(reversed(column), reversed(wanted), strict=True):
        up.append(min(want, bottom - spot.height))
        bottom = up[-1] - gap
    for spot, low, high in zip(column, down, reversed(up), strict=True):
        spot.top = (low + high) / 2
