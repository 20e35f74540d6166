"""Read from a log which stages were rebuilt while its run went on."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import groupby
from typing import NamedTuple

from graphnav import Graph, Recording, Stage, UserError, shown_path
from graphnav.core.catalog import Catalog
from graphnav.core.codec import DecodeError, decode
from graphnav.core.graph import Channel, Node, part_of
from graphnav.core.messages import Changed


class StageChange(NamedTuple):
    """A stage that takes the place of the one of the same name; ``at_us``: by the run's clock, from then on.

    ``data``: the message that tells of it.
    """

    at_us: int
    node: Node
    data: bytes


class MadeChange(NamedTuple):
    """Changes of one time with their new stages; ``graph``: the complete one from then on."""

    at_us: int
    graph: Graph
    nodes: tuple[Node, ...]
    """Those that step in the replay."""
    stages: Mapping[str, Stage]
    data: tuple[bytes, ...]


def read_changes(recording: Recording, graph: Graph, catalog: Catalog) -> tuple[tuple[StageChange, ...], list[str]]:
    """Return the changes that a replay with ``graph`` repeats, and a notice for each that it does not.

    Not repeated is what cannot be read, the change of a stage for which the replay has other settings (``--set``), and
    a change that reads what this graph does not have.
    """
    channels: dict[str, Channel] = dict(graph.channels)
    nodes = {node.name: node for node in graph.nodes}
    changes: list[StageChange] = []
    notices: dict[str, None] = {}
    for index in range(recording.count(Changed.CHANNEL)):
        data = recording.event(Changed.CHANNEL, index).data
        try:
            at_us, _, changed = decode(Changed, data)
        except DecodeError:
            notices[f"{shown_path(recording.path)}: a change of a stage is damaged, and not repeated"] = None
            continue
        before = nodes.get(changed.stage)
        if before is None or before.is_overridden:
            why = "the graph does not have it" if before is None else "--set gives it other settings"
            notices[f"changes of stage '{changed.stage}' while the run went on are not repeated: {why}"] = None
            continue
        try:
            node = part_of(changed.stage_yaml, graph.path, catalog, loads_plugins=False).node(changed.stage)
        except (UserError, StopIteration) as error:
            why = error.problems[0].what if isinstance(error, UserError) else "it is not in its message"
            notices[f"the change of stage '{changed.stage}' to {changed.use} is not repeated: {why}"] = None
            continue
        absent = [i.channel.ref for i in node.inputs if i.channel and channels.get(i.channel.ref) != i.channel]
        if absent:
            why = f"it reads {absent[0]}, which this graph does not have"
            notices[f"the change of stage '{changed.stage}' to {changed.use} is not repeated: {why}"] = None
            continue
        channels |= {channel.ref: channel for channel in node.outputs.values()}
        node = replace(node, every_ms=before.every_ms, deadline_ms=before.deadline_ms)
        changes.append(StageChange(at_us, node, data))
    return tuple(sorted(changes, key=lambda change: change.at_us)), list(notices)


def make_changes(changes: Iterable[StageChange], graph: Graph, stepped: Iterable[str]) -> Iterator[MadeChange]:
    """Yield changes of a ``graph`` with new stages, those of one time together.

    ``stepped``: the stages that step in the replay; others change the firing order alone.

    Raises
    ------
    UserError
        A stage cannot be made.
    """
    names = frozenset(stepped)
    for at_us, group in groupby(changes, lambda change: change.at_us):
        found = tuple(group)
        nodes = tuple(change.node for change in found)
        graph = graph.with_nodes(nodes)
        steps = tuple(node for node in nodes if node.name in names)
        stages = {node.name: graph.make_stage(node.name) for node in steps}
        yield MadeChange(at_us, graph, steps, stages, tuple(change.data for change in found))
