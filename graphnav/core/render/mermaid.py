"""Draw a graph as a Mermaid flow chart."""

from __future__ import annotations

from html import escape

from graphnav.core.errors import printable
from graphnav.core.graph import Graph
from graphnav.core.render.boxes import Box, boxes_of, wires_of

_SHAPES = {"source": ("([", "])"), "stage": ("[", "]"), "input": ("[/", "/]"), "output": ("[/", "/]")}


def mermaid_of(graph: Graph) -> str:
    """Return a Mermaid flow chart; sampled wires are dotted, sources are rounded, inputs and outputs slanted."""
    boxes = boxes_of(graph)
    lines = ["flowchart LR"]
    for box in boxes:
        left, right = _SHAPES[box.kind]
        lines.append(f'    {_id(box.key)}{left}"{_label(box)}"{right}')
    for wire in wires_of(boxes):
        arrow = "-.->" if wire.latest else "-->"
        label = f'|"{wire.channel.port}"|'
        lines.append(f"    {_id(wire.channel.stage)} {arrow}{label} {_id(wire.reader)}")
    return printable("\n".join(lines)) + "\n"


def _label(box: Box) -> str:
    aliases = ", ".join(port.alias for port in box.outputs) if box.kind == "input" else ""
    name = escape(box.name) + (f" ({escape(aliases)})" if aliases else "")
    return f"<b>{name}</b><br/>{box.use}"


def _id(key: str) -> str:
    """Return an identifier that is not a Mermaid keyword, such as ``end``."""
    return "s_" + key.replace(" ", "_").replace(".", "_")
