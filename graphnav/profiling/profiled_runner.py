"""A lockstep runner that measures some of its ticks."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from enum import Enum, auto

from graphnav.bus import Bus
from graphnav.graph import Channel, Graph
from graphnav.messages import Message
from graphnav.profiling.step_functions import StepFunctions
from graphnav.profiling.stopwatch import Part, Stopwatch
from graphnav.profiling.timed import TimedBus, TimedSink, TimedStep
from graphnav.runner import Runner
from graphnav.runner.durations import Durations
from graphnav.runner.lockstep_unit import LockstepUnit
from graphnav.runner.owned_stages import Sink
from graphnav.stage import Stage

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


class ProfiledRunner(Runner):
    """Runs ticks with and without instruments in turns.

    Their order is random, so that no source has the same period, and the same in every run.

    ``sinks``: the log, then the tap if there is one. ``functions``: None to not look inside of the steps.
    """

    def __init__(
        self,
        graph: Graph,
        stages: Mapping[str, Stage],
        bus: Bus,
        sinks: Sequence[Sink],
        *,
        watch: Stopwatch,
        functions: StepFunctions | None,
    ) -> None:
        timed_sinks = [TimedSink(sink, part, watch) for sink, part in zip(sinks, (Part.LOG, Part.TAP), strict=False)]
        super().__init__(graph, stages, TimedBus(bus, watch), timed_sinks)
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
        for name, unit in self._units.items():
            unit.wrap_step(TimedStep(name, watch, functions).wrap)

    def tick(self) -> str | None:
        """Fire everything that is due at the next stamp; return the outcome if a source ended the run."""
        kind = self._next_kind()
        if kind is TickKind.TIMED:
            self._sent.clear()
            self.watch.begin()
            outcome = super().tick()
            self.watch.end()
            self._count_messages()
        elif kind is TickKind.BARE:
            begin_ns = self.watch.clock()
            outcome = super().tick()
            self.bare.add((self.watch.clock() - begin_ns) / 1e9)
        else:
            with self._sampled(kind):
                outcome = super().tick()
        self.kinds[kind] += 1
        return outcome

    def _count_messages(self) -> None:
        for channel, n_bytes in self._sent:
            self.n_bytes[channel] += n_bytes
            self.n_messages[channel] += 1

    def _sampled(self, kind: TickKind) -> AbstractContextManager[None]:
        return nullcontext() if self.functions is None or kind is TickKind.WARM_UP else self.functions.on()

    def _next_kind(self) -> TickKind:
        if self.ticks < WARM_UP:
            return TickKind.WARM_UP
        if not self.watch.n_ticks:
            return TickKind.TIMED
        if self._random.random() < 0.25:
            return TickKind.BARE
        if self.functions is not None and self._random.random() < 0.5:
            return TickKind.SAMPLED
        return TickKind.TIMED

    def _fire(self, unit: LockstepUnit, stamp: int) -> str | None:
        if self.watch.is_on:
            self.watch.enter(Part.STAGE, unit.node.name)
            outcome = super()._fire(unit, stamp)
            self.watch.close(Part.CHECK)
            self.watch.leave()
            return outcome
        return super()._fire(unit, stamp)

    def _publish(self, channel: Channel, utime: int, message: Message) -> None:
        if not self.watch.is_on:
            super()._publish(channel, utime, message)
            return
        stage = self.watch.name
        self.watch.close(Part.CHECK)
        super()._publish(channel, utime, message)
        self.watch.enter(Part.CHECK, stage)

    def _encode(self, channel: Channel, utime: int, seq: int, message: Message) -> bytes:
        if not self.watch.is_on:
            return super()._encode(channel, utime, seq, message)
        self.watch.enter(Part.ENCODE, channel.name)
        data = super()._encode(channel, utime, seq, message)
        self.watch.leave()
        self._sent.append((channel.name, len(data)))
        return data

    def _decode(self, channel: Channel, data: bytes) -> tuple[int, Message]:
        if not self.watch.is_on:
            return super()._decode(channel, data)
        self.watch.enter(Part.DECODE, channel.name)
        decoded = super()._decode(channel, data)
        self.watch.leave()
        return decoded
