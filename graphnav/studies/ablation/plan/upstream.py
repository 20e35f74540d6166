"""Stages upstream of others, and those that drive the world of a graph."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from graphnav import Graph
from graphnav.core.graph import Node


def upstream(graph: Graph, starts: Iterable[str], *, through_sources: bool) -> frozenset[str]:
    """Return stages and all that they read from, directly or not; beyond a source only if that is asked for."""
    nodes = {node.name: node for node in graph.nodes}
    found: set[str] = set()
    pending = [name for name in starts if name in nodes]
    while pending:
        name = pending.pop()
        if name in found:
            continue
        found.add(name)
        if through_sources or not nodes[name].is_source:
            pending += [writer for writer in _writers(nodes[name]) if writer in nodes]
    return frozenset(found)


def driving_stages(graph: Graph) -> frozenset[str]:
    """Return the stages, without the sources, whose messages reach a source: those that drive a world's robot."""
    commands = [writer for source in graph.sources for writer in _writers(source)]
    return upstream(graph, commands, through_sources=True) - {source.name for source in graph.sources}


def measured_stages(graph: Graph, stage: str) -> frozenset[str]:
    """Return the stages whose work the metrics of a stage measure.

    These are what it is made from, up to the sources. A score that reads sources alone measures the drive.
    """
    sources = {source.name for source in graph.sources}
    found = upstream(graph, [stage], through_sources=False) - sources
    is_of_drive = stage in sources or (found == {stage} and graph.node(stage).stage_class.role == "score")
    return driving_stages(graph) if is_of_drive else found


def _writers(node: Node) -> Iterator[str]:
    return (i.channel.stage for i in node.inputs if i.channel is not None)
