"""Lay out the boxes and wires of a drawing: stages from left to right, wires as SVG paths."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from graphnav.core.render.boxes import Box, Wire
from graphnav.core.render.layers import Layers, Route, Spot, layers_of

HEAD = 42.0
_GAP_Y = 26.0
_MARGIN = 24.0
_LANE = 14.0
"""Sizes in SVG units: a box's head, the gap between boxes, the margin, and the distance of wires that run back."""

_PALETTE = ("#2563a8", "#b4501e", "#2e7d4f", "#7a4b9e", "#a3324b", "#0f7b83", "#7d6a14", "#4a5563")


@dataclass(frozen=True)
class Sizes:
    """Sizes in SVG units: of a character, a port's row, the gap between columns, the space below a box's ports.

    ``min_chars``: minimum width of a box, characters. ``lane``: straight part of a wire after its port.
    """

    char: float = 8.0
    min_chars: int = 0
    row: float = 20.0
    gap_x: float = 76.0
    lane: float = 0.0
    foot: float = 8.0


@dataclass(frozen=True)
class PlacedBox:
    """A box and its position."""

    box: Box
    x: float
    y: float
    width: float
    height: float
    row: float
    colour: str

    def port_y(self, port: str, *, is_input: bool) -> float:
        """Return the y coordinate of a port's row."""
        names = [p.name for p in (self.box.inputs if is_input else self.box.outputs)]
        return self.y + HEAD + (names.index(port) + 0.5) * self.row


@dataclass(frozen=True)
class PlacedWire:
    """A wire: its SVG path from ``start`` to ``end`` (x, y), in the colour of its writer."""

    wire: Wire
    path: str
    start: tuple[float, float]
    end: tuple[float, float]
    colour: str


@dataclass(frozen=True)
class Geometry:
    """A complete drawing; boxes by key."""

    width: float
    height: float
    boxes: Mapping[str, PlacedBox]
    wires: Sequence[PlacedWire]


def geometry_of(drawn: Sequence[Box], sizes: Sizes | None = None) -> Geometry:
    """Return the positions of boxes, in columns by data flow depth, and the wires between them."""
    sizes = sizes or Sizes()
    heights = {box.key: HEAD + sizes.row * max(len(box.inputs), len(box.outputs), 1) + sizes.foot for box in drawn}
    layers = layers_of(drawn, heights, _GAP_Y)
    boxes = _boxes(drawn, layers, sizes)
    bottom = max(box.y + box.height for box in boxes.values())
    right = max(box.x + box.width for box in boxes.values()) + _MARGIN + _LANE
    columns = _column_edges(layers, boxes)
    wires, lanes = [], 0
    for route in layers.routes:
        lanes += route.runs_back
        wires.append(_wire(route, boxes, columns, bottom + _LANE * lanes, sizes.lane))
    return Geometry(right, bottom + _LANE * lanes + _MARGIN, boxes, wires)


def _boxes(drawn: Sequence[Box], layers: Layers, sizes: Sizes) -> dict[str, PlacedBox]:
    groups = list(dict.fromkeys(box.group for box in drawn))
    colours = {group: _PALETTE[number % len(_PALETTE)] for number, group in enumerate(groups)}
    by_key = {box.key: box for box in drawn}
    boxes, x = {}, _MARGIN + _LANE
    for column in layers.columns:
        spots = [spot for spot in column if spot.box]
        chars = [max(_characters(by_key[spot.box]), sizes.min_chars) for spot in spots]
        width = max(chars, default=0) * sizes.char
        for spot in spots:
            box = by_key[spot.box]
            boxes[box.key] = PlacedBox(box, x, _MARGIN + spot.top, width, spot.height, sizes.row, colours[box.group])
        x += width + sizes.gap_x
    return boxes


def _characters(box: Box) -> int:
    """Return the required width of a box, characters."""
    rows = max(len(box.inputs), len(box.outputs))
    inputs = [len(port.name) for port in box.inputs] + [0] * rows
    outputs = [len(port.name) + (len(port.alias) + 1) * bool(port.alias) for port in box.outputs] + [0] * rows
    ports = max((a + b + 5 for a, b in zip(inputs[:rows], outputs[:rows], strict=True)), default=0)
    return max(ports, len(box.name) + 3, len(box.use) + 3)


def _column_edges(layers: Layers, boxes: dict[str, PlacedBox]) -> list[tuple[float, float]]:
    edges = []
    for column in layers.columns:
        box = next(boxes[spot.box] for spot in column if spot.box)
        edges.append((box.x, box.x + box.width))
    return edges


def _wire(
    route: Route, boxes: dict[str, PlacedBox], columns: list[tuple[float, float]], lane_y: float, lane: float
) -> PlacedWire:
    wire = route.wire
    start, end = boxes[wire.channel.stage], boxes[wire.reader]
    x, y = start.x + start.width, start.port_y(wire.channel.port, is_input=False)
    to_x, to_y = end.x, end.port_y(wire.port, is_input=True)
    if route.runs_back:
        path = _path_back(x, y, to_x, to_y, lane_y, lane)
    else:
        path = f"M{x:.1f},{y:.1f}" + _path_on(x, y, [*_passes(route.passes, columns), (to_x, to_x, to_y)], lane)
    return PlacedWire(wire, path, (x, y), (to_x, to_y), start.colour)


def _passes(spots: list[Spot], columns: list[tuple[float, float]]) -> list[tuple[float, float, float]]:
    return [(*columns[spot.column], _MARGIN + spot.top) for spot in spots]


def _path_on(x: float, y: float, passes: list[tuple[float, float, float]], lane: float) -> str:
    """Return curves through columns: (left edge, right edge, height) of each, straight for ``lane`` after each."""
    path = ""
    for left, right, height in passes:
        bend = (left - x - lane) / 2
        x += lane
        path += f"H{x:.1f}" if lane else ""
        path += f"C{x + bend:.1f},{y:.1f} {left - bend:.1f},{height:.1f} {left:.1f},{height:.1f}"
        path += f"H{right:.1f}" if right > left else ""
        x, y = right, height
    return path


def _path_back(x: float, y: float, to_x: float, to_y: float, lane_y: float, lane: float) -> str:
    """Return a path with rounded corners that runs back below all boxes."""
    r, out, back = 8.0, x + lane + 18.0, to_x - 22.0
    return (
        f"M{x:.1f},{y:.1f}H{out - r:.1f}Q{out:.1f},{y:.1f} {out:.1f},{y + r:.1f}V{lane_y - r:.1f}"
        f"Q{out:.1f},{lane_y:.1f} {out - r:.1f},{lane_y:.1f}H{back + r:.1f}"
        f"Q{back:.1f},{lane_y:.1f} {back:.1f},{lane_y - r:.1f}V{to_y + r:.1f}"
        f"Q{back:.1f},{to_y:.1f} {back + r:.1f},{to_y:.1f}H{to_x:.1f}"
    )
