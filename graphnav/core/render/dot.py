"""Draw a graph in Graphviz's dot language."""

from __future__ import annotations

from graphnav.core.errors import printable
from graphnav.core.graph import Graph
from graphnav.core.render.boxes import Box, OutPort, boxes_of, wires_of


def dot_of(graph: Graph) -> str:
    """Return the text of a directed graph for ``dot``; sampled wires are dashed, inputs and outputs round."""
    boxes = boxes_of(graph)
    lines = [
        f'digraph "{graph.path.stem}" {{'.replace("\\", ""),
        "    rankdir=LR;",
        '    node [shape=record, fontname="Helvetica"];',
        '    edge [fontname="Helvetica", fontsize=10];',
    ]
    lines += [f'    "{_id(box.key)}" [label="{_label(box)}"{_shape(box)}];' for box in boxes]
    for wire in wires_of(boxes):
        style = " [style=dashed, constraint=false]" if wire.latest else ""
        start = f'"{wire.channel.stage}":"out_{wire.channel.port}":e'
        lines.append(f'    {start} -> "{_id(wire.reader)}":"in_{wire.port}":w{style};')
    return printable("\n".join([*lines, "}"])) + "\n"


def _id(key: str) -> str:
    return key.replace(" ", "_")


def _shape(box: Box) -> str:
    return ", shape=Mrecord" if box.kind in ("input", "output") else ""


def _label(box: Box) -> str:
    inputs = "|".join(f"<in_{port.name}> {port.name}" for port in box.inputs)
    outputs = "|".join(f"<out_{port.name}> {port.name}{_alias(box, port)}" for port in box.outputs)
    rows = [f"{_text(box.name)}\\n{box.use}", f"{{{{{inputs}}}|{{{outputs}}}}}"]
    return f"{{{'|'.join(rows)}}}"


def _alias(box: Box, port: OutPort) -> str:
    return f" ({_text(port.alias)})" if box.kind == "input" else ""


def _text(text: str) -> str:
    """Escape a string for the label of a record."""
    return "".join(f"\\{char}" if char in '\\"{}|<> ' else char for char in text)
