"""Draw a graph in Graphviz' language."""

from __future__ import annotations

from graphnav.graph import Graph, Node
from graphnav.render.wires import wires_of


def dot_of(graph: Graph) -> str:
    """Return the text of a directed graph for ``dot``; sampled wires are dashed."""
    lines = [
        f'digraph "{graph.path.stem}" {{'.replace("\\", ""),
        "    rankdir=LR;",
        '    node [shape=record, fontname="Helvetica"];',
        '    edge [fontname="Helvetica", fontsize=10];',
    ]
    lines += [f'    "{node.name}" [label="{_label(node)}"];' for node in graph.nodes]
    for wire in wires_of(graph):
        style = " [style=dashed, constraint=false]" if wire.latest else ""
        start = f'"{wire.channel.stage}":"out_{wire.channel.port}":e'
        lines.append(f'    {start} -> "{wire.reader}":"in_{wire.port}":w{style};')
    return "\n".join([*lines, "}"]) + "\n"


def _label(node: Node) -> str:
    inputs = "|".join(f"<in_{i.port.name}> {i.port.name}" for i in node.inputs)
    outputs = "|".join(f"<out_{port}> {port}" for port in node.outputs)
    rows = [f"{node.name}\\n{node.use}", f"{{{{{inputs}}}|{{{outputs}}}}}"]
    return f"{{{'|'.join(rows)}}}"
