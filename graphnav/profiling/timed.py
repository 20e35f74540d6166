"""Time a bus, the receivers of messages and the steps of a stage."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from graphnav.bus import Bus, Handler
from graphnav.profiling.step_functions import StepFunctions
from graphnav.profiling.stopwatch import Part, Stopwatch
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


class TimedStep:
    """Wraps the step of a stage.

    From its end to the stage's first message, and between messages, the outputs are checked.
    """

    def __init__(self, stage: str, watch: Stopwatch, functions: StepFunctions | None) -> None:
        self._stage, self._watch, self._functions = stage, watch, functions

    def wrap(self, step: Callable[..., Any]) -> Callable[..., Any]:
        """Return the timed step."""
        stage, watch, functions = self._stage, self._watch, self._functions

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
