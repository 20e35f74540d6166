"""Measure what the instruments themselves cost."""

from __future__ import annotations

import statistics
from collections.abc import Callable

from graphnav.develop.profiling.stopwatch import Part, Stopwatch
from graphnav.develop.profiling.tick_spans import TimedSink

_BATCHES, _MIN_WRITES = 9, 200


def reading_us(n_channels: int, clock: Callable[[], int]) -> float:
    """Return the cost of one reading of the clock, microseconds, with the call around it that a plain run lacks.

    The median over batches of what a timed receiver of ``n_channels`` channels that does nothing takes longer than the
    receiver alone. In a tick it is rather more: caches hold other things.
    """
    names = [f"channel {number}" for number in range(n_channels)] * (1 + _MIN_WRITES // n_channels)
    watch, sink = Stopwatch(clock), _Nothing()
    timed = TimedSink(sink, Part.LOG, watch)
    found = []
    for _ in range(_BATCHES):
        begin_ns = clock()
        for name in names:
            sink.write(name, 0, b"")
        middle_ns = clock()
        watch.begin()
        for name in names:
            timed.write(name, 0, b"")
        end_ns = clock()
        found.append((end_ns - middle_ns - (middle_ns - begin_ns)) / (2 * len(names)) / 1e3)
    return max(0.0, statistics.median(found))


class _Nothing:
    """A receiver that does nothing."""

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Take one message."""
