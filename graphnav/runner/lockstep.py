"""Lockstep: simulated time, one tick a stamp, as fast as the machine allows or paced."""

from __future__ import annotations

import heapq
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from enum import StrEnum
from functools import partial
from typing import Any, Protocol

from graphnav.bus import Bus
from graphnav.codec import EncodeError, decode, encode
from graphnav.graph import Channel, Graph
from graphnav.messages import Message
from graphnav.runner.lifecycle import close_stages, reset_stages
from graphnav.runner.lockstep_unit import LockstepUnit
from graphnav.stage import Source, Stage


class Outcome(StrEnum):
    """How a run ended."""

    GOAL = "goal"
    CONTACT = "contact"
    TIMEOUT = "timeout"
    END = "end"
    STOPPED = "stopped"
    FAILED = "failed"


class Sink(Protocol):
    """What takes every message of a run: the log, the tap."""

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Take one message as it was published."""


class Runner:
    """Owns the stages of a graph and the bus, and fires by the firing rule.

    A source fires at stamps ``round(k * 1e6 / rate_hz)`` microseconds; sources that are due at one stamp fire in the
    graph's order, then every other stage whose plain inputs are complete, in firing order. Joins that are still
    incomplete at the end of the tick are dropped and counted.
    """

    def __init__(self, graph: Graph, stages: Mapping[str, Stage], bus: Bus, sinks: Sequence[Sink]) -> None:
        """Wire ``stages`` (by name) of ``graph`` over ``bus``; every message also goes to the ``sinks``."""
        self.graph = graph
        self.ticks = 0
        self.utime = 0
        self.is_ready = False
        """Whether every stage was reset."""
        self._bus = bus
        self._sinks = sinks
        self._seqs: dict[str, int] = defaultdict(int)
        self._units = {node.name: LockstepUnit(node, stages[node.name], self._publish) for node in graph.nodes}
        self._order = [self._units[node.name] for node in graph.order]
        self._due: list[tuple[int, int, int]] = []
        self._sources = [self._units[node.name] for node in graph.sources]
        self._rates: list[float] = []
        self._plain = {i.channel.name for n in graph.nodes for i in n.inputs if i.channel and i.port.is_plain}
        self._consumed = self._subscribe()

    @property
    def units(self) -> Mapping[str, LockstepUnit]:
        """The stages at work, by name."""
        return self._units

    @property
    def next_utime(self) -> int:
        """The stamp of the next tick, microseconds."""
        return self._due[0][0]

    def reset(self, seed: int) -> None:
        """Make every stage's state anew from ``seed`` and set the clock to 0.

        Raises
        ------
        StageError
            A stage cannot be made ready.
        """
        self._seqs.clear()
        self.is_ready = False
        self.ticks = self.utime = 0
        reset_stages(self._units, seed)
        self._rates = [source.rate() for unit in self._sources if isinstance(source := unit.stage, Source)]
        self._due = [(0, place, 0) for place in range(len(self._sources))]
        heapq.heapify(self._due)
        self.is_ready = True

    def tick(self) -> str | None:
        """Run everything that belongs to the next stamp; return the outcome where a source ended the run.

        Raises
        ------
        StageError
            A stage raised, or returned what it may not.
        """
        self.utime = stamp = self._due[0][0]
        outcome = None
        while self._due[0][0] == stamp:
            _, place, k = heapq.heappop(self._due)
            outcome = self._fire(self._sources[place], stamp) or outcome
            heapq.heappush(self._due, (round((k + 1) * 1e6 / self._rates[place]), place, k + 1))
        for unit in self._order:
            if unit.is_complete:
                self._fire(unit, stamp)
            else:
                unit.discard()
        self.ticks += 1
        return outcome

    def run(self, until_s: float | None = None, before_tick: Callable[[int], bool] = lambda _: True) -> str:
        """Tick until a source ends the run, ``until_s`` of simulated time are over, or ``before_tick`` says no.

        ``before_tick`` gets the stamp of the tick to come: progress, pace and Ctrl-C hang on it.
        """
        until = None if until_s is None else round(until_s * 1e6)
        while True:
            if until is not None and self.next_utime > until:
                return Outcome.TIMEOUT
            if not before_tick(self.next_utime):
                return Outcome.STOPPED
            if outcome := self.tick():
                return outcome

    def close(self) -> None:
        """Release what the stages hold; each is closed, also if another one fails to.

        Raises
        ------
        StageError
            The first failure, once every stage was closed.
        """
        close_stages(self._units, self.utime / 1e6)

    def _fire(self, unit: LockstepUnit, stamp: int) -> str | None:
        outcome = unit.fire(stamp)
        self._bus.drain()
        return outcome

    def _publish(self, channel: Channel, utime: int, message: Message) -> None:
        if utime != self.utime and channel.name in self._plain:
            raise ValueError("it has a stamp of its own, but feeds a plain input: read it as Latest or Since")
        consumed = channel.name in self._consumed
        seq = self._seqs[channel.name]
        self._seqs[channel.name] = seq + 1
        if not consumed and not self._sinks:
            return
        try:
            data = encode(message, utime, seq)
        except EncodeError as error:
            raise ValueError(str(error)) from error
        for sink in self._sinks:
            sink.write(channel.name, utime, data)
        if consumed:
            self._bus.publish(channel.name, data)

    def _subscribe(self) -> set[str]:
        """Subscribe once to each channel that somebody consumes; return their names."""
        consumers: dict[str, list[Callable[[int, Any], None]]] = defaultdict(list)
        messages: dict[str, type[Message]] = {}
        for node in self.graph.nodes:
            for link in node.inputs:
                if link.channel is not None:
                    unit = self._units[node.name]
                    consumers[link.channel.name].append(partial(unit.deliver, link.port.name))
                    messages[link.channel.name] = link.channel.message
        for name, deliver_all in consumers.items():
            self._bus.subscribe(name, partial(_receive, messages[name], deliver_all))
        return set(consumers)


def _receive(
    message_class: type[Message], deliver_all: list[Callable[[int, Any], None]], _channel: str, data: bytes
) -> None:
    utime, _, message = decode(message_class, data)
    for deliver in deliver_all:
        deliver(utime, message)
