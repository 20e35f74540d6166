"""The layout of a run's graph for the page: boxes and wires in SVG units."""

from __future__ import annotations

from typing import Any

from graphnav import About
from graphnav.core.catalog import Catalog
from graphnav.core.render import AnnouncedGraph, Geometry, Sizes

_SIZES = Sizes(char=7.2, min_chars=17, row=32.0, gap_x=96.0, lane=62.0, foot=30.0)
_LABEL = 50.0
"""Space for rate, latency and losses on every wire, which runs straight below them, and after the last box; and for
the step time in every box."""


def layout_of(about: About, catalog: Catalog) -> dict[str, Any]:
    """Return boxes, wires and the LCM channels of each reference of the graph that a run announces.

    Raises
    ------
    UserError
        The announcement is not a graph, or too large to be drawn.
    """
    graph = AnnouncedGraph.read(about, catalog)
    drawing = graph.geometry(_SIZES)
    return {
        "about": graph.about,
        "width": drawing.width + _LABEL,
        "height": drawing.height,
        "boxes": _boxes(drawing),
        "wires": _wires(drawing),
        "names": graph.names,
    }


def _boxes(drawing: Geometry) -> list[dict[str, Any]]:
    return [
        {
            "key": placed.box.key,
            "name": placed.box.name,
            "use": placed.box.use,
            "kind": placed.box.kind,
            "x": placed.x,
            "y": placed.y,
            "width": placed.width,
            "height": placed.height,
            "foot": _SIZES.foot,
            "colour": placed.colour,
            "inputs": [
                {"name": port.name, "y": placed.port_y(port.name, is_input=True), "open": port.channel is None}
                for port in placed.box.inputs
            ],
            "outputs": [
                {
                    "name": port.name,
                    "alias": port.alias,
                    "ref": port.channel.ref,
                    "y": placed.port_y(port.name, is_input=False),
                }
                for port in placed.box.outputs
            ],
        }
        for placed in drawing.boxes.values()
    ]


def _wires(drawing: Geometry) -> list[dict[str, Any]]:
    return [
        {
            "ref": placed.wire.channel.ref,
            "reader": f"{placed.wire.reader}.{placed.wire.port}",
            "sampled": placed.wire.latest,
            "path": placed.path,
            "start": placed.start,
            "end": placed.end,
            "colour": placed.colour,
        }
        for placed in drawing.wires
    ]
