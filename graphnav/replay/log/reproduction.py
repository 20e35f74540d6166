"""Find the sources that make again what a log leaves out, and what they were stepped with."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

from graphnav import Graph, Stage
from graphnav.core.graph import Channel, Node
from graphnav.replay.log.contents import Contents, Logged
from graphnav.replay.log.log_graph import LogGraph
from graphnav.replay.log.missing_messages import MissingMessages, numbered_gaps
from graphnav.replay.log.schedule import ticks_of


class Heard(NamedTuple):
    """A recorded message that a source samples: from its tick on, or from the next one if its writer fires later."""

    utime: int
    is_before: bool
    """Whether its writer fires before the source."""
    message: Logged


@dataclass(frozen=True)
class Reproduction:
    """The sources of a run that are stepped again, as they ran, with the recorded messages of their inputs."""

    graph: Graph
    """The graph of the run."""
    seed: int
    nodes: tuple[Node, ...]
    channels: tuple[Channel, ...]
    """The reproduced channels: reproducible outputs that the replay needs."""

    @property
    def outputs(self) -> tuple[Channel, ...]:
        """All channels of the sources: those that are recorded are compared."""
        return tuple(channel for node in self.nodes for channel in node.outputs.values())

    @property
    def inputs(self) -> tuple[Channel, ...]:
        """The channels that the sources sample."""
        found = (i.channel for node in self.nodes for i in node.inputs if i.channel is not None)
        return tuple({channel.ref: channel for channel in found}.values())

    def make_stages(self) -> dict[str, Stage]:
        """Return new stages of the sources, which publish what was read in the run and what the replay needs.

        Raises
        ------
        UserError
            One cannot be made.
        """
        read = self.graph.read.union(channel.ref for channel in self.channels)
        return replace(self.graph, nodes=self.nodes, order=()).make_stages(read)

    def missing_inputs(self, contents: Contents) -> Iterator[tuple[Channel, list[MissingMessages]]]:
        """Yield the inputs of which messages are missing."""
        for channel in self.inputs:
            if missing := numbered_gaps(contents.messages[channel.name]):
                yield channel, missing

    def heard_by(self, node: Node, contents: Contents) -> list[Heard]:
        """Return what a source samples, in the order in which it was published."""
        names = [source.name for source in self.graph.sources]
        earlier = names[: names.index(node.name)]
        channels = [i.channel for i in node.inputs if i.channel is not None]
        of_sources = [channel for channel in channels if channel.stage in names]
        found = [
            Heard(tick.utime, stage in earlier, message)
            for tick in ticks_of(self.graph, of_sources, contents, is_complete=False)
            for stage, messages in tick.played.items()
            for message in messages
        ]
        of_stages = {channel.name for channel in channels if channel.stage not in names}
        later = [(utime, message) for utime, message in self._by_tick(contents) if message.channel in of_stages]
        found += (Heard(utime, is_before=False, message=message) for utime, message in later)
        return sorted(found, key=lambda heard: (heard.utime, not heard.is_before))

    def _by_tick(self, contents: Contents) -> Iterator[tuple[int, Logged]]:
        """Yield the messages in file order, each with the timestamp of the tick that has begun."""
        stamped = {n.outputs[port.name].name for n in self.graph.nodes for port in n.output_ports if port.stamped}
        utime = 0
        for message in contents.order:
            utime = utime if message.channel in stamped else message.utime
            yield utime, message


def reproduction_of(made: LogGraph, contents: Contents, *, wants_all: bool) -> Reproduction | None:
    """Return the sources to step again, None if the log holds what a replay reads.

    ``wants_all``: whether everything that the run published is wanted, not only what a stage of the replay reads.
    """
    if made.recorded is None or made.about is None or not contents.is_own:
        return None
    read = {i.channel.ref for node in made.graph.nodes for i in node.inputs if i.channel is not None}
    nodes, channels = [], []
    for node in made.recorded.sources:
        known = [one for one in node.reproducible if made.graph.channels.get(one.ref) == one]
        needed = [one for one in known if one.ref in read or (wants_all and contents.messages[one.name])]
        if needed:
            nodes.append(node)
            channels += needed
    return Reproduction(made.recorded, made.about.seed, tuple(nodes), tuple(channels)) if nodes else None
