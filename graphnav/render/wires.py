"""The wires of a graph, as drawings need them."""

from __future__ import annotations

from dataclasses import dataclass

from graphnav.graph import Channel, Graph


@dataclass(frozen=True)
class Wire:
    """A channel and one of its readers."""

    channel: Channel
    reader: str
    port: str
    latest: bool


def wires_of(graph: Graph) -> list[Wire]:
    """Return every wire, readers in the file's order."""
    return [
        Wire(i.channel, node.name, i.port.name, not i.port.is_plain)
        for node in graph.nodes
        for i in node.inputs
        if i.channel is not None
    ]
