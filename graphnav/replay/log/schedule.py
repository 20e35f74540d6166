"""Schedule the ticks of a replay: the messages of the log to publish at each timestamp."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from graphnav import Graph
from graphnav.core.graph import Channel
from graphnav.replay.log.contents import Contents, Logged


@dataclass
class Tick:
    """One timestamp and its recorded messages that are not published by stepping stages, by writer."""

    utime: int
    played: dict[str, list[Logged]] = field(default_factory=lambda: defaultdict(list))


def ticks_of(graph: Graph, held: Iterable[Channel], contents: Contents, *, is_complete: bool = True) -> list[Tick]:
    """Return the ticks of a log that have messages on the ``held`` channels, in order of their timestamps.

    A message belongs to the tick of its timestamp. A message with its own timestamp belongs to the tick before it in
    the file, unless its source or a downstream stage has already published in that tick, else to the next one. In a
    log that is not complete, what downstream stages have published may be missing: then one that is later than the tick
    belongs to the next one, too.
    """
    walk = _Walk(graph, held, is_complete=is_complete)
    for message in contents.order:
        if message.channel in walk.channels:
            walk.take(message)
    walk.finish()
    return [walk.ticks[utime] for utime in sorted(walk.ticks)]


class _Walk:
    """Iterates over a log in file order."""

    def __init__(self, graph: Graph, held: Iterable[Channel], *, is_complete: bool) -> None:
        self.ticks: dict[int, Tick] = {}
        self.channels = {channel.name: channel for channel in graph.channels.values()}
        self._held = {channel.name for channel in held}
        self._is_complete = is_complete
        self._sources = {node.name for node in graph.sources}
        self._places = _places(graph)
        self._stamped = {
            node.outputs[port.name].name for node in graph.nodes for port in node.output_ports if port.stamped
        }
        self._utime: int | None = None
        self._reached: dict[str, int] = {}
        """The last published port of each source in this tick."""
        self._is_past_sources = False
        self._waiting: list[Logged] = []

    def take(self, message: Logged) -> None:
        """Take the next message."""
        channel = self.channels[message.channel]
        if message.channel not in self._stamped:
            if message.utime != self._utime:
                self._begin(message.utime)
        elif self._is_of_next(channel) or self._is_later(message):
            self._waiting.append(message)
            return
        self._note(channel)
        self._put(message)

    def finish(self) -> None:
        """Put messages that wait for a next tick into one of their own, at the end of the log."""
        if self._waiting and self._utime is not None:
            self._begin(max(self._utime + 1, *(message.utime for message in self._waiting)))

    def _begin(self, utime: int) -> None:
        self._utime, self._is_past_sources = utime, False
        self._reached.clear()
        for message in self._waiting:
            self._put(message)
        self._waiting.clear()

    def _is_of_next(self, channel: Channel) -> bool:
        if self._utime is None or self._waiting or self._is_past_sources:
            return True
        return self._places[channel.ref] <= self._reached.get(channel.stage, -1)

    def _is_later(self, message: Logged) -> bool:
        return not self._is_complete and self._utime is not None and message.utime > self._utime

    def _note(self, channel: Channel) -> None:
        if channel.stage in self._sources:
            self._reached[channel.stage] = self._places[channel.ref]
        else:
            self._is_past_sources = True

    def _put(self, message: Logged) -> None:
        if message.channel in self._held and self._utime is not None:
            tick = self.ticks.setdefault(self._utime, Tick(self._utime))
            tick.played[self.channels[message.channel].stage].append(message)


def _places(graph: Graph) -> Mapping[str, int]:
    """Return the index of each channel among the outputs of its stage, by reference."""
    return {channel.ref: place for node in graph.nodes for place, channel in enumerate(node.outputs.values())}
