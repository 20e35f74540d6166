"""Draw a graph as SVG: stages from left to right, one line for each wire, broken where it is sampled."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape

from graphnav.graph import Graph
from graphnav.render.boxes import Box, boxes_of
from graphnav.render.layers import Layers, Route, Spot, layers_of

_CHAR = 8.0
_ROW = 20.0
_HEAD = 42.0
_FOOT = 8.0
_GAP_X = 76.0
_GAP_Y = 26.0
_MARGIN = 24.0
_LANE = 14.0
"""Sizes in SVG units: a character's width, a port's row, a box's head and foot, gaps between boxes, the margin, and
the distance of wires that run back."""

_PALETTE = ("#2563a8", "#b4501e", "#2e7d4f", "#7a4b9e", "#a3324b", "#0f7b83", "#7d6a14", "#4a5563")

_STYLE = """
  .dataflow text { font: 12px "DejaVu Sans", Verdana, sans-serif; fill: #24292f; }
  .dataflow .name { font-weight: bold; font-size: 13px; fill: #ffffff; }
  .dataflow .use { font-size: 11px; fill: #ffffff; }
  .dataflow .renamed { font-size: 10px; fill: #6b7280; }
  .dataflow .box { fill: #ffffff; stroke: #9aa4b2; }
  .dataflow .wire { fill: none; stroke-width: 1.6; }
  .dataflow .sampled { stroke-dasharray: 5 4; }
  .dataflow .mark { fill: none; stroke: #e08e00; stroke-width: 3; }
  .dataflow .note { font-weight: bold; font-size: 12px; fill: #b26f00; }
"""
"""Of this picture alone, also where a page holds it."""


@dataclass(frozen=True)
class _Place:
    """Where a box is."""

    box: Box
    x: float
    y: float
    width: float
    height: float
    colour: str

    def port_y(self, port: str, *, is_input: bool) -> float:
        """Return the height of a port's row."""
        names = [p.name for p in (self.box.inputs if is_input else self.box.outputs)]
        return self.y + _HEAD + (names.index(port) + 0.5) * _ROW


def svg_of(graph: Graph, notes: Mapping[str, str] | None = None) -> str:
    """Return the text of an SVG picture; stages that ``notes`` names are marked, with their note above them."""
    drawn = boxes_of(graph)
    heights = {box.key: _HEAD + _ROW * max(len(box.inputs), len(box.outputs), 1) + _FOOT for box in drawn}
    layers = layers_of(graph, drawn, heights, _GAP_Y)
    boxes = _boxes(drawn, layers)
    bottom = max(box.y + box.height for box in boxes.values())
    right = max(box.x + box.width for box in boxes.values()) + _MARGIN + _LANE
    columns = _column_edges(layers, boxes)
    wires, lanes = [], 0
    for route in layers.routes:
        lanes += route.runs_back
        wires.append(_wire(route, boxes, columns, bottom + _LANE * lanes))
    height = bottom + _LANE * lanes + _MARGIN
    size = f'viewBox="0 0 {right:.0f} {height:.0f}" width="{right:.0f}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" class="dataflow" {size}>'
    title = f"<title>{escape(graph.about or graph.path.stem)}</title>"
    background = '<rect width="100%" height="100%" fill="#f6f8fa"/>'
    parts = [head, title, f"<style>{_STYLE}</style>", background, *wires]
    marks = [_mark(boxes[stage], note) for stage, note in (notes or {}).items()]
    return "\n".join([*parts, *(_box(box) for box in boxes.values()), *marks, "</svg>"]) + "\n"


def _boxes(drawn: Sequence[Box], layers: Layers) -> dict[str, _Place]:
    groups = list(dict.fromkeys(box.group for box in drawn))
    colours = {group: _PALETTE[number % len(_PALETTE)] for number, group in enumerate(groups)}
    by_key = {box.key: box for box in drawn}
    boxes, x = {}, _MARGIN + _LANE
    for column in layers.columns:
        spots = [spot for spot in column if spot.box]
        width = max((_width(by_key[spot.box]) for spot in spots), default=0.0)
        for spot in spots:
            box = by_key[spot.box]
            boxes[box.key] = _Place(box, x, _MARGIN + spot.top, width, spot.height, colours[box.group])
        x += width + _GAP_X
    return boxes


def _width(box: Box) -> float:
    rows = max(len(box.inputs), len(box.outputs))
    inputs = [len(port.name) for port in box.inputs] + [0] * rows
    outputs = [len(port.name) + (len(port.alias) + 1) * bool(port.alias) for port in box.outputs] + [0] * rows
    ports = max((a + b + 5 for a, b in zip(inputs[:rows], outputs[:rows], strict=True)), default=0)
    return _CHAR * max(ports, len(box.name) + 3, len(box.use) + 3)


def _column_edges(layers: Layers, boxes: dict[str, _Place]) -> list[tuple[float, float]]:
    edges = []
    for column in layers.columns:
        box = next(boxes[spot.box] for spot in column if spot.box)
        edges.append((box.x, box.x + box.width))
    return edges


def _wire(route: Route, boxes: dict[str, _Place], columns: list[tuple[float, float]], lane_y: float) -> str:
    wire = route.wire
    start, end = boxes[wire.channel.stage], boxes[wire.reader]
    x, y = start.x + start.width, start.port_y(wire.channel.port, is_input=False)
    to_x, to_y = end.x, end.port_y(wire.port, is_input=True)
    if route.runs_back:
        path = _path_back(x, y, to_x, to_y, lane_y)
    else:
        path = f"M{x:.1f},{y:.1f}" + _path_on(x, y, [*_passes(route.passes, columns), (to_x, to_x, to_y)])
    kind = "wire sampled" if wire.latest else "wire"
    title = f"<title>{wire.channel.ref} ({wire.channel.message.__name__})</title>"
    line = f'<path class="{kind}" stroke="{start.colour}" d="{path}">{title}</path>'
    head = f"M{to_x:.1f},{to_y:.1f}l-7,-4v8z"
    return f'{line}<path fill="{start.colour}" d="{head}"/>'


def _passes(spots: list[Spot], columns: list[tuple[float, float]]) -> list[tuple[float, float, float]]:
    return [(*columns[spot.column], _MARGIN + spot.top) for spot in spots]


def _path_on(x: float, y: float, passes: list[tuple[float, float, float]]) -> str:
    """Return curves through columns: (left edge, right edge, height) of each."""
    path = ""
    for left, right, height in passes:
        bend = (left - x) / 2
        path += f"C{x + bend:.1f},{y:.1f} {left - bend:.1f},{height:.1f} {left:.1f},{height:.1f}"
        path += f"H{right:.1f}" if right > left else ""
        x, y = right, height
    return path


def _path_back(x: float, y: float, to_x: float, to_y: float, lane_y: float) -> str:
    """Return a line with round corners that runs back below everything."""
    r, out, back = 8.0, x + 18.0, to_x - 22.0
    return (
        f"M{x:.1f},{y:.1f}H{out - r:.1f}Q{out:.1f},{y:.1f} {out:.1f},{y + r:.1f}V{lane_y - r:.1f}"
        f"Q{out:.1f},{lane_y:.1f} {out - r:.1f},{lane_y:.1f}H{back + r:.1f}"
        f"Q{back:.1f},{lane_y:.1f} {back:.1f},{lane_y - r:.1f}V{to_y + r:.1f}"
        f"Q{back:.1f},{to_y:.1f} {back + r:.1f},{to_y:.1f}H{to_x:.1f}"
    )


def _box(place: _Place) -> str:
    box, x, y, width = place.box, place.x, place.y, place.width
    head = _HEAD - 6
    band = f"M{x:.1f},{y + head:.1f}v{6 - head:.1f}q0,-6 6,-6h{width - 12:.1f}q6,0 6,6v{head - 6:.1f}z"
    parts = [
        f'<g><rect class="box" x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{place.height:.1f}" rx="6"/>',
        f'<path fill="{place.colour}" d="{band}"/>',
        f'<text class="name" x="{x + 9:.1f}" y="{y + 15:.1f}">{escape(box.name)}</text>',
        f'<text class="use" x="{x + 9:.1f}" y="{y + 30:.1f}">{escape(box.use)}</text>',
    ]
    for port in box.inputs:
        port_y = place.port_y(port.name, is_input=True)
        parts.append(f'<text x="{x + 9:.1f}" y="{port_y + 4:.1f}">{escape(port.name)}</text>')
        if port.channel is None:
            parts.append(f'<circle cx="{x:.1f}" cy="{port_y:.1f}" r="3.5" fill="#ffffff" stroke="#9aa4b2"/>')
    for out in box.outputs:
        renamed = f'<tspan class="renamed" dx="5">{escape(out.alias)}</tspan>' if out.alias else ""
        port_y = place.port_y(out.name, is_input=False)
        parts.append(
            f'<text x="{x + width - 9:.1f}" y="{port_y + 4:.1f}" text-anchor="end">{escape(out.name)}{renamed}</text>'
            f'<circle cx="{x + width:.1f}" cy="{port_y:.1f}" r="2.5" fill="{place.colour}"/>'
        )
    return "".join(parts) + "</g>"


def _mark(place: _Place, note: str) -> str:
    frame = f'x="{place.x - 4:.1f}" y="{place.y - 4:.1f}" width="{place.width + 8:.1f}" height="{place.height + 8:.1f}"'
    text = f'<text class="note" x="{place.x:.1f}" y="{place.y - 9:.1f}">{escape(note)}</text>'
    return f'<rect class="mark" {frame} rx="9"/>{text}'
