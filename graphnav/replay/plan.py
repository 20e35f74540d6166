"""Plan a replay: the channels played from the log, and the stages that step."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

from graphnav import Graph, UserError, did_you_mean
from graphnav.core.graph import Channel
from graphnav.replay.log.changes import StageChange


@dataclass(frozen=True)
class Plan:
    """The played channels and the stepping stages."""

    graph: Graph
    """The complete graph; behind its stages those that took their places while the run went on."""
    began: Graph
    """The complete graph as the run began."""
    stepped: Graph
    """The stepping stages of ``graph``, in firing order; its channels are those of the complete graph."""
    changes: tuple[StageChange, ...]
    """When stages took the places of others."""
    played: tuple[Channel, ...]
    """Channels played from the log, in graph order."""
    needed: tuple[Channel, ...]
    """Played channels that a stepping stage reads."""
    compared: tuple[Channel, ...]
    """Channels published by stepping stages, in firing order, except played ones."""
    copied: tuple[Channel, ...]
    """Channels of stages that are not needed, copied to the replay's log."""
    not_needed: tuple[str, ...]
    """Stages that neither step nor are played: no stepping stage depends on them."""

    @property
    def stepped_names(self) -> frozenset[str]:
        """The names of the stepping stages."""
        return frozenset(node.name for node in self.stepped.nodes)

    @property
    def stepped_at_first(self) -> Graph:
        """The stepping stages as the run began, in firing order."""
        return _stepping(self.began, self.stepped_names)

    def readers_of(self, channel: Channel) -> list[str]:
        """Return the stepping stages that read a channel."""
        readers = (node.name for node in self.stepped.nodes if any(i.channel == channel for i in node.inputs))
        return list(dict.fromkeys(readers))


def make_plan(
    graph: Graph, play: Sequence[str] = (), reproduced: Collection[str] = (), changes: Sequence[StageChange] = ()
) -> Plan:
    """Return the plan that plays sources, agents, inputs, and the channels ``play`` (``stage.port``).

    ``reproduced``: channels of sources that are not played, because their sources make them again, by reference.
    ``changes``: of stages while the run went on.

    Raises
    ------
    UserError
        ``play`` names an unknown channel, or no stage is left to step.
    """
    began, later = graph, tuple(change.node for change in changes)
    graph = replace(graph, nodes=(*graph.nodes, *later), order=(*graph.order, *later))
    given = (node for node in graph.nodes if node.is_source or node.stage_class.is_agent)
    played = {channel.ref for node in given for channel in node.outputs.values()} | set(graph.inputs)
    for word in play:
        played |= _refs(graph, word)
    recorded, played = played, played.difference(reproduced)
    stepping = {n.name for n in graph.order if not n.outputs or any(c.ref not in recorded for c in n.outputs.values())}
    not_needed = []
    while (idle := _idle(graph, stepping)) is not None:
        stepping.discard(idle)
        not_needed.append(idle)
    if not stepping:
        raise UserError.of("no stage is left to step: every channel is played", "leave out some of --play")
    stepped = _stepping(graph, stepping)
    read = {i.channel.ref for node in stepped.nodes for i in node.inputs if i.channel is not None}
    channels = [channel for ref, channel in graph.channels.items() if ref in played]
    compared = dict.fromkeys(c for node in stepped.order for c in node.outputs.values() if c.ref not in played)
    of_no_use = {channel.ref for node in graph.nodes if node.name in not_needed for channel in node.outputs.values()}
    return Plan(
        graph=graph,
        began=began,
        stepped=stepped,
        changes=tuple(changes),
        played=tuple(channels),
        needed=tuple(channel for channel in channels if channel.ref in read),
        compared=tuple(compared),
        copied=tuple(channel for ref, channel in graph.channels.items() if ref in of_no_use - played),
        not_needed=tuple(not_needed),
    )


def _stepping(graph: Graph, names: Collection[str]) -> Graph:
    nodes, order = (tuple(n for n in every if n.name in names) for every in (graph.nodes, graph.order))
    return replace(graph, nodes=nodes, order=order)


def notices_of(plan: Plan) -> Iterator[str]:
    """Yield a notice for each stage that is changed by ``--set`` but does not step."""
    for node in plan.graph.nodes:
        if node.name not in plan.stepped_names and node.is_overridden:
            yield f"{node.name}: --set has no effect on this stage, because it does not step in this replay"


def _refs(graph: Graph, word: str) -> set[str]:
    """Return the channels that match ``stage.port`` or ``stage``."""
    if word in graph.channels:
        return {word}
    of_stage = {ref for ref, channel in graph.channels.items() if channel.stage == word}
    if not of_stage:
        stages = {channel.stage for channel in graph.channels.values()}
        hint = did_you_mean(word, {*graph.channels, *stages}) or f"channels are {', '.join(graph.channels)}"
        raise UserError.of(f"--play: the graph has no channel {word!a}", hint)
    return of_stage


def _idle(graph: Graph, stepping: Collection[str]) -> str | None:
    """Return a stage whose readers all do not step."""
    sources = {node.name for node in graph.sources}
    readers: dict[str, set[str]] = defaultdict(set)
    for node in graph.nodes:
        for i in node.inputs:
            if i.channel is not None:
                readers[i.channel.stage].add(node.name)
    for ref in graph.outputs:
        readers[graph.channels[ref].stage].add("")
    serving = {"", *stepping} | sources
    names = (node.name for node in graph.order if node.name in stepping)
    return next((name for name in names if readers[name] and not readers[name] & serving), None)
