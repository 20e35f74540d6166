"""Time a bus, the receivers of messages and the steps of a stage."""

from __future__ import annotations

from graphnav.bus import Bus, Handler
from graphnav.profiling.step_functions import StepFunctions
from graphnav.profiling.stopwatch import Part, Stopwatch
from graphnav.runner.durations import Durations
from graphnav.runner.owned_stages import Sink


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

    def subscribe(self, channel: str, handler: Handler) -> None:
        """Call ``handler(channel, data)`` for each message of exactly this channel."""

        def received(channel: str, data: bytes) -> None:
            if self._watch.is_on:
                self._watch.lap(Part.DELIVER, channel)
            handler(channel, data)

        self._timed.subscribe(channel, received)

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


class TimedSteps(Durations):
    """The durations of a stage's steps, which also tell the stopwatch when a step has ended.

    From there to its first message, and between messages, a stage's outputs are checked.
    """

    def __init__(self, stage: str, watch: Stopwatch, functions: StepFunctions | None) -> None:
        super().__init__()
        self._stage, self._watch, self._functions = stage, watch, functions

    def add(self, duration_s: float) -> None:
        """Count the step that has just ended."""
        if self._functions is not None:
            self._functions.stop()
        super().add(duration_s)
        if self._watch.is_on:
            self._watch.lap_of(Part.STEP, self._stage, round(duration_s * 1e9))
            self._watch.enter(Part.CHECK, self._stage)
