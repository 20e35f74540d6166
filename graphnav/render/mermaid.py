"""Draw a graph as a Mermaid flow chart."""

from __future__ import annotations

from graphnav.graph import Graph
from graphnav.render.wires import wires_of


def mermaid_of(graph: Graph) -> str:
    """Return the text of a Mermaid flow chart; sampled wires are dotted, sources are rounded."""
    lines = ["flowchart LR"]
    for node in graph.nodes:
        label = f'"<b>{node.name}</b><br/>{node.use}"'
        lines.append(f"    {_id(node.name)}" + (f"([{label}])" if node.is_source else f"[{label}]"))
    for wire in wires_of(graph):
        arrow = "-.->" if wire.latest else "-->"
        label = f'|"{wire.channel.port}"|'
        lines.append(f"    {_id(wire.channel.stage)} {arrow}{label} {_id(wire.reader)}")
    return "\n".join(lines) + "\n"


def _id(stage: str) -> str:
    """Return an identifier that is no word of Mermaid's, such as ``end``."""
    return f"s_{stage}"
