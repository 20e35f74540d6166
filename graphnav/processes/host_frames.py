"""Frames between a run and a host that has some of its processes, besides those of a process."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from enum import IntEnum

from graphnav import Graph
from graphnav.core.graph import resolved_yaml
from graphnav.core.spec import RunOptions

SERVICE = "host of stages"
"""As `host_link` calls it."""


class HostKind(IntEnum):
    """The kind of a frame, besides those of `frames.Kind`."""

    JOIN = 100
    """Of the run, the first: which process it wants."""
    INTERRUPT = 101
    """Of the run: break off the step."""
    ENDED = 102
    """Of the host, the last: the process has ended, by which status."""


def fingerprint(graph: Graph, host: str) -> str:
    """Return what two machines must have alike of a host's processes: all values, with paths as they are written."""
    parts = {name: part for name, part in graph.deploy.items() if part.host == host}
    stages = {stage for part in parts.values() for stage in part.stages}
    nodes = tuple(node for node in graph.nodes if node.name in stages)
    alone = replace(graph, about="", nodes=nodes, deploy=parts, run=RunOptions(), inputs={}, outputs={}, queues={})
    alone = replace(alone, notices=(), file_notices=())
    return hashlib.sha256(resolved_yaml(alone).encode()).hexdigest()
