"""Connect the stages of a graph by a bus in simulated time."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from graphnav.bus import Bus
from graphnav.codec import DecodeError, decode
from graphnav.graph import Channel, Graph
from graphnav.messages import Message, Twist
from graphnav.runner.lockstep_unit import LockstepUnit
from graphnav.runner.owned_stages import OwnedStages, Sink
from graphnav.stage import Stage


class WiredStages(OwnedStages[LockstepUnit]):
    """Owns the stages of a graph and the bus; a subclass decides when each stage fires."""

    def __init__(self, graph: Graph, stages: Mapping[str, Stage], bus: Bus, sinks: Sequence[Sink]) -> None:
        """Wire ``stages`` (by name) of ``graph`` over ``bus``; every message also goes to the ``sinks``."""
        super().__init__(sinks)
        self.graph = graph
        self._bus = bus
        self._units = {node.name: LockstepUnit(node, stages[node.name], self._publish) for node in graph.nodes}
        self._plain = {i.channel.name for n in graph.nodes for i in n.inputs if i.channel and i.port.is_plain}
        self._consumed = self._subscribe()
        self._commands = {channel.name: channel for channel in command_channels(graph)}
        self._commanded_us: dict[str, int] = {}
        """The stamp of the last command on each of these channels."""

    def give_stops(self) -> None:
        """Take back the last command on every channel that moves a world: the sinks get a stop with its stamp.

        No stage gets it: the run has ended.

        Raises
        ------
        LogError
            A log cannot be written.
        """
        for name, utime in self._commanded_us.items():
            channel = self._commands[name]
            self._give(channel, utime, self._next_seq(channel), Twist(v_mps=0.0, omega_radps=0.0))
        self._commanded_us.clear()

    def _fire(self, unit: LockstepUnit, stamp: int) -> str | None:
        outcome = unit.fire(stamp)
        self._bus.drain()
        return outcome

    def _fire_complete(self, unit: LockstepUnit, stamp: int) -> None:
        """Fire a stage if its plain inputs are complete, else drop them."""
        if unit.is_complete:
            self._fire(unit, stamp)
        else:
            unit.discard()

    def _publish(self, channel: Channel, utime: int, message: Message) -> None:
        if utime != self.utime and channel.name in self._plain:
            raise ValueError("it has a stamp of its own, but feeds a plain input: read it as Latest or Since")
        consumed = channel.name in self._consumed
        seq = self._next_seq(channel)
        if channel.name in self._commands:
            self._commanded_us[channel.name] = utime
        if not consumed and not self._sinks:
            return
        data = self._give(channel, utime, seq, message)
        if consumed:
            self._bus.publish(channel.name, data)

    def _decode(self, channel: Channel, data: bytes) -> tuple[int, Message]:
        """Return the stamp and the message of a channel's bytes. A subclass may measure it by channel."""
        try:
            utime, _, message = decode(channel.message, data)
        except DecodeError as error:
            raise DecodeError(f"stage '{channel.stage}': output '{channel.port}' is {error}") from error
        return utime, message

    def _subscribe(self) -> set[str]:
        """Subscribe once to each channel that a stage consumes; return the names."""
        consumers: dict[str, list[Callable[[int, Any], None]]] = defaultdict(list)
        channels: dict[str, Channel] = {}
        for node in self.graph.nodes:
            for link in node.inputs:
                if link.channel is not None:
                    unit = self._units[node.name]
                    consumers[link.channel.name].append(partial(unit.deliver, link.port.name))
                    channels[link.channel.name] = link.channel
        for name, deliver_all in consumers.items():
            self._bus.subscribe(name, partial(self._receive, channels[name], deliver_all))
        return set(consumers)

    def _receive(
        self, channel: Channel, deliver_all: list[Callable[[int, Any], None]], _name: str, data: bytes
    ) -> None:
        utime, message = self._decode(channel, data)
        first, *others = deliver_all
        first(utime, message)
        for deliver in others:  # a stage that changes what it was given changes nothing for others
            deliver(utime, message.twin())


def command_channels(graph: Graph) -> list[Channel]:
    """Return the channels of commands that sources sample: what moves the robot of a world."""
    found = (i.channel for node in graph.sources for i in node.inputs if i.channel is not None)
    return list({channel.name: channel for channel in found if channel.message is Twist}.values())
