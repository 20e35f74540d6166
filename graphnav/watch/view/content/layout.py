"""The drawing of an announced graph as JSON-compatible values: the same boxes and paths as ``graphnav draw``."""

from __future__ import annotations

from typing import Any

from graphnav.core.render import Box, PlacedBox, PlacedWire, Sizes, geometry_of
from graphnav.watch.view.content.announced_graph import AnnouncedGraph

_SIZES = Sizes(char=7.2, min_chars=17, row=32.0, gap_x=96.0, lane=62.0, foot=30.0)
_LABEL = 50.0
"""Space for rate, latency and losses on every wire, which runs straight below them, and after the last box; and for
the step time in every box."""


def layout_of(graph: AnnouncedGraph) -> dict[str, Any]:
    """Return boxes, wires and the LCM channels of each reference, in SVG units."""
    drawing = geometry_of(graph.boxes, _SIZES)
    return {
        "about": graph.about,
        "width": drawing.width + _LABEL,
        "height": drawing.height,
        "boxes": [_box(placed) for placed in drawing.boxes.values()],
        "wires": [_wire(placed) for placed in drawing.wires],
        "names": graph.names,
    }


def _box(placed: PlacedBox) -> dict[str, Any]:
    box: Box = placed.box
    return {
        "key": box.key,
        "name": box.name,
        "use": box.use,
        "kind": box.kind,
        "x": placed.x,
        "y": placed.y,
        "width": placed.width,
        "height": placed.height,
        "foot": _SIZES.foot,
        "colour": placed.colour,
        "inputs": [
            {"name": port.name, "y": placed.port_y(port.name, is_input=True), "open": port.channel is None}
            for port in box.inputs
        ],
        "outputs": [
            {
                "name": port.name,
                "alias": port.alias,
                "ref": port.channel.ref,
                "y": placed.port_y(port.name, is_input=False),
            }
            for port in box.outputs
        ],
    }


def _wire(placed: PlacedWire) -> dict[str, Any]:
    wire = placed.wire
    return {
        "ref": wire.channel.ref,
        "reader": f"{wire.reader}.{wire.port}",
        "sampled": wire.latest,
        "path": placed.path,
        "start": placed.start,
        "end": placed.end,
        "colour": placed.colour,
    }
