"""Draw a graph as SVG: stages from left to right, one line for each wire, broken where it is sampled."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

from graphnav.graph import Graph
from graphnav.render.boxes import boxes_of
from graphnav.render.geometry import HEAD, PlacedBox, PlacedWire, geometry_of

_STYLE = """
  svg.dataflow { max-width: 100%; height: auto; }
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


def svg_of(graph: Graph, notes: Mapping[str, str] | None = None) -> str:
    """Return the text of an SVG picture; stages that ``notes`` names are marked, with their note above them."""
    drawing = geometry_of(boxes_of(graph))
    size = f'viewBox="0 0 {drawing.width:.0f} {drawing.height:.0f}" width="{drawing.width:.0f}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" class="dataflow" {size}>'
    title = f"<title>{escape(graph.about or graph.path.stem)}</title>"
    background = '<rect width="100%" height="100%" fill="#f6f8fa"/>'
    parts = [head, title, f"<style>{_STYLE}</style>", background, *map(_wire, drawing.wires)]
    marks = [_mark(drawing.boxes[stage], note) for stage, note in (notes or {}).items()]
    return "\n".join([*parts, *map(_box, drawing.boxes.values()), *marks, "</svg>"]) + "\n"


def _wire(placed: PlacedWire) -> str:
    wire, (x, y) = placed.wire, placed.end
    kind = "wire sampled" if wire.latest else "wire"
    title = f"<title>{wire.channel.ref} ({wire.channel.message.__name__})</title>"
    line = f'<path class="{kind}" stroke="{placed.colour}" d="{placed.path}">{title}</path>'
    return f'{line}<path fill="{placed.colour}" d="M{x:.1f},{y:.1f}l-7,-4v8z"/>'


def _box(place: PlacedBox) -> str:
    box, x, y, width = place.box, place.x, place.y, place.width
    head = HEAD - 6
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


def _mark(place: PlacedBox, note: str) -> str:
    frame = f'x="{place.x - 4:.1f}" y="{place.y - 4:.1f}" width="{place.width + 8:.1f}" height="{place.height + 8:.1f}"'
    text = f'<text class="note" x="{place.x:.1f}" y="{place.y - 9:.1f}">{escape(note)}</text>'
    return f'<rect class="mark" {frame} rx="9"/>{text}'
