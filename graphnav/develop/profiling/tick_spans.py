"""Measure ticks of lockstep by nested spans."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from enum import Enum, auto
from typing import Any

from graphnav import Message
from graphnav.core.bus import Bus
from graphnav.core.graph import Channel
from graphnav.core.runner import Durations, Sink, Spans, Unit
from graphnav.develop.profiling.step_functions import StepFunctions
from graphnav.develop.profiling.stopwatch import Part, Stopwatch

WARM_UP = 20
"""The first ticks, which load code and allocate buffers, are not measured."""


class TickKind(Enum):
    """How a tick is measured."""

    WARM_UP = auto()
    TIMED = auto()
    BARE = auto()
    """Only its duration: the difference from timed ticks is the cost of the instruments."""
    SAMPLED = auto()
    """Only the functions inside of the steps."""


class TickSpans(Spans):
    """Measures some ticks, with and without instruments in turns.

    Their order is random, so that no source has the same period, and the same in every run.

    ``functions``: None to not look inside of the steps.
    """

    def __init__(self, watch: Stopwatch, functions: StepFunctions | None) -> None:
        self.watch, self.functions = watch, functions
        self.bare = Durations()
        """Durations of ticks without instruments."""
        self.kinds: Counter[TickKind] = Counter()
        """How many ticks there were of each kind."""
        self.n_bytes: Counter[str] = Counter()
        """Bytes of the messages of timed ticks, by channel."""
        self.n_messages: Counter[str] = Counter()
        """Their number."""
        self._random = random.Random(0)
        self._sent: list[tuple[str, int]] = []

    def tick(self, tick: Callable[[], str | None]) -> Callable[[], str | None]:
        """Measure a tick as its kind says."""

        def measured() -> str | None:
            kind = self._next_kind()
            if kind is TickKind.TIMED:
                self._sent.clear()
                self.watch.begin()
                outcome = tick()
                self.watch.end()
                for channel, n_bytes in self._sent:
                    self.n_bytes[channel] += n_bytes
                    self.n_messages[channel] += 1
            elif kind is TickKind.BARE:
                begin_ns = self.watch.clock()
                outcome = tick()
                self.bare.add((self.watch.clock() - begin_ns) / 1e9)
            else:
                with self._sampled(kind):
                    outcome = tick()
            self.kinds[kind] += 1
            return outcome

        return measured

    def fire(self, fire: Callable[..., str | None]) -> Callable[..., str | None]:
        """Measure a firing; what none of the other spans accounts for is its own."""

        def timed(unit: Unit[Any], stamp: int, inputs: dict[str, Any], age_s: float) -> str | None:
            if not self.watch.is_on:
                return fire(unit, stamp, inputs, age_s)
            self.watch.enter(Part.STAGE, unit.node.name)
            outcome = fire(unit, stamp, inputs, age_s)
            self.watch.close(Part.CHECK)
            self.watch.leave()
            return outcome

        return timed

    def step(self, stage: str, step: Callable[..., Any]) -> Callable[..., Any]:
        """Measure a step; from its end to the stage's first message, and between messages, the outputs are checked."""
        watch, functions = self.watch, self.functions

        def timed_step(**inputs: Any) -> Any:
            if watch.is_on:
                watch.enter(Part.STEP, stage)
                try:
                    return step(**inputs)
                finally:
                    watch.leave()
                    watch.enter(Part.CHECK, stage)
            if functions is not None and functions.is_on:
                with functions.sampled(stage):
                    return step(**inputs)
            return step(**inputs)

        return timed_step

    def publish(self, publish: Callable[..., None]) -> Callable[..., None]:
        """End the check of an output, and begin that of the next one."""

        def timed(channel: Channel, utime: int, message: Message) -> None:
            if not self.watch.is_on:
                publish(channel, utime, message)
                return
            stage = self.watch.name
            self.watch.close(Part.CHECK)
            publish(channel, utime, message)
            self.watch.enter(Part.CHECK, stage)

        return timed

    def encode(self, encode: Callable[..., bytes]) -> Callable[..., bytes]:
        """Measure encoding, by channel."""

        def timed(channel: Channel, utime: int, number: int, message: Message) -> bytes:
            if not self.watch.is_on:
                return encode(channel, utime, number, message)
            self.watch.enter(Part.ENCODE, channel.name)
            data = encode(channel, utime, number, message)
            self.watch.leave()
            self._sent.append((channel.name, len(data)))
            return data

        return timed

    def decode(self, decode: Callable[..., tuple[int, int, Message]]) -> Callable[..., tuple[int, int, Message]]:
        """Measure decoding, by channel."""

        def timed(channel: Channel, data: bytes) -> tuple[int, int, Message]:
            if not self.watch.is_on:
                return decode(channel, data)
            self.watch.enter(Part.DECODE, channel.name)
            decoded = decode(channel, data)
            self.watch.leave()
            return decoded

        return timed

    def sinks(self, sinks: Sequence[Sink]) -> Sequence[Sink]:
        """Measure writing to the log, and to the tap if there is one."""
        return [TimedSink(sink, part, self.watch) for sink, part in zip(sinks, (Part.LOG, Part.TAP), strict=False)]

    def bus(self, bus: Bus) -> Bus:
        """Measure sending and delivering."""
        return TimedBus(bus, self.watch)

    def _sampled(self, kind: TickKind) -> AbstractContextManager[None]:
        return nullcontext() if self.functions is None or kind is TickKind.WARM_UP else self.functions.on()

    def _next_kind(self) -> TickKind:
        if self.kinds.total() < WARM_UP:
            return TickKind.WARM_UP
        if not self.watch.n_ticks:
            return TickKind.TIMED
        if self._random.random() < 0.25:
            return TickKind.BARE
        if self.functions is not None and self._random.random() < 0.5:
            return TickKind.SAMPLED
        return TickKind.TIMED


class TimedBus(Bus):
    """Another bus of kind ``memq://``, timed by channel: sending, and the way from the queue to the handler."""

    def __init__(self, bus: Bus, watch: Stopwatch) -> None:
        self.url = bus.url  # no LCM object of its own, so no Bus.__init__: everything goes through the other bus
        self._timed, self._watch = bus, watch

    def publish(self, channel: str, data: bytes) -> None:
        """Send a message."""
        if not self._watch.is_on:
            self._timed.publish(channel, data)
            return
        self._watch.enter(Part.DELIVER, channel)
        self._timed.publish(channel, data)
        self._watch.leave()

    def subscribe(self, channel: str, handler: Callable[[str, bytes], None]) -> None:
        """Call ``handler(channel, data)`` for each message of exactly this channel."""

        def received(channel: str, data: bytes) -> None:
            if self._watch.is_on:
                self._watch.lap(Part.DELIVER, channel)
            handler(channel, data)

        self._timed.subscribe(channel, received)

    def close(self) -> None:
        """Close the other bus."""
        self._timed.close()

    def drain(self) -> int:
        """Deliver until the queue is empty; return the number of messages."""
        if self._watch.is_on:
            self._watch.close(Part.CHECK)
        return self._timed.drain()


class TimedSink:
    """A receiver of every message, timed by channel as one part of the work."""

    def __init__(self, sink: Sink, part: Part, watch: Stopwatch) -> None:
        self._sink, self._part, self._watch = sink, part, watch

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Write one message."""
        if not self._watch.is_on:
            self._sink.write(channel, utime, data)
            return
        self._watch.enter(self._part, channel)
        self._sink.write(channel, utime, data)
        self._watch.leave()
