"""Which channels a replay plays from the log and which stages step again."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

from graphnav.errors import UserError, did_you_mean
from graphnav.graph import Channel, Graph, Node
from graphnav.graph.wiring.settings import SET


@dataclass(frozen=True)
class Plan:
    """What is played and what steps."""

    graph: Graph
    """All of it."""
    stepped: Graph
    """The stages that step, in their firing order; its channels are those of the entire graph."""
    played: tuple[Channel, ...]
    """What comes from the log, in the order of the graph."""
    needed: tuple[Channel, ...]
    """What of it a stage reads that steps."""
    compared: tuple[Channel, ...]
    """What the stages publish that step, in firing order, without what is played."""
    copied: tuple[Channel, ...]
    """What is neither played nor compared, because its stage is not needed: a log of the replay holds it as it was."""
    not_needed: tuple[str, ...]
    """Stages that neither step nor are played: only stages read them that do not step either."""

    @property
    def stepped_names(self) -> frozenset[str]:
        """The names of the stages that step."""
        return frozenset(node.name for node in self.stepped.nodes)

    def readers_of(self, channel: Channel) -> list[str]:
        """Return the stages that step and read a channel."""
        return [node.name for node in self.stepped.nodes if any(i.channel == channel for i in node.inputs)]


def make_plan(graph: Graph, play: Sequence[str] = ()) -> Plan:
    """Return the plan that plays what sources and inputs published, and the channels ``play`` (``stage.port``) too.

    Raises
    ------
    UserError
        ``play`` names a channel that the graph does not have, or nothing is left to step.
    """
    played = {channel.ref for node in graph.sources for channel in node.outputs.values()} | set(graph.inputs)
    for word in play:
        played |= _refs(graph, word)
    stepping = {n.name for n in graph.order if not n.outputs or any(c.ref not in played for c in n.outputs.values())}
    not_needed = []
    while (idle := _idle(graph, stepping)) is not None:
        stepping.discard(idle)
        not_needed.append(idle)
    if not stepping:
        raise UserError.of("no stage is left that steps: every channel is played", "leave out some of --play")
    nodes, order = (tuple(n for n in given if n.name in stepping) for given in (graph.nodes, graph.order))
    read = {i.channel.ref for node in nodes for i in node.inputs if i.channel is not None}
    channels = [channel for ref, channel in graph.channels.items() if ref in played]
    compared = tuple(c for node in order for c in node.outputs.values() if c.ref not in played)
    of_no_use = {channel.ref for node in graph.nodes if node.name in not_needed for channel in node.outputs.values()}
    return Plan(
        graph=graph,
        stepped=replace(graph, nodes=nodes, order=order),
        played=tuple(channels),
        needed=tuple(channel for channel in channels if channel.ref in read),
        compared=compared,
        copied=tuple(channel for ref, channel in graph.channels.items() if ref in of_no_use - played),
        not_needed=tuple(not_needed),
    )


def notices_of(plan: Plan) -> Iterator[str]:
    """Yield what ``--set`` says of stages that do not step."""
    for node in plan.graph.nodes:
        if node.name not in plan.stepped_names and _is_set(node):
            yield f"{node.name}: what --set says of it changes nothing, because it does not step in this replay"


def _refs(graph: Graph, word: str) -> set[str]:
    """Return the channels that ``stage.port`` or ``stage`` means."""
    if word in graph.channels:
        return {word}
    of_stage = {ref for ref, channel in graph.channels.items() if channel.stage == word}
    if not of_stage:
        stages = {channel.stage for channel in graph.channels.values()}
        hint = did_you_mean(word, {*graph.channels, *stages}) or f"channels are {', '.join(graph.channels)}"
        raise UserError.of(f"--play: the graph has no channel {word!a}", hint)
    return of_stage


def _idle(graph: Graph, stepping: Collection[str]) -> str | None:
    """Return a stage that steps only for stages that do not."""
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


def _is_set(node: Node) -> bool:
    return bool(node.use_note) or any(setting.origin == SET for setting in node.settings.values())
