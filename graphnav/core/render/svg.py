"""Draw a graph as SVG: stages from left to right, one line for each wire, broken where it is sampled."""

from __future__ import annotations

from collections.abc import Mapping

from markupsafe import Markup

from graphnav.core.graph import Graph
from graphnav.core.html_templates import rendered
from graphnav.core.render.boxes import boxes_of
from graphnav.core.render.geometry import HEAD, geometry_of


def svg_of(graph: Graph, notes: Mapping[str, str] | None = None) -> Markup:
    """Return an SVG document; stages in ``notes`` are marked, with the note above them."""
    drawing = geometry_of(boxes_of(graph))
    picture = rendered(
        "graphnav.core.render",
        "dataflow.svg",
        title=graph.about or graph.path.stem,
        width=drawing.width,
        height=drawing.height,
        head=HEAD - 6,
        wires=drawing.wires,
        boxes=drawing.boxes.values(),
        marks=[(drawing.boxes[stage], note) for stage, note in (notes or {}).items()],
    )
    return picture + "\n"
