"""Follow the stream of one writer by its sequence numbers, and a timeline of stamps that may become the accepted."""

from __future__ import annotations

import math

_MAX_LOST = 30
_UNKNOWN_PERIOD_S = 0.02


class WriterStream:
    """The newest sequence number of a writer, its stamp and its arrival.

    A writer may leave ``seq`` at 0 in every message: then 0 continues its stream.
    """

    def __init__(self, seq: int, stamp: int, arrival_s: float) -> None:
        self.seq = seq
        self.arrival_s = arrival_s
        """Arrival of the newest message of the stream, monotonic seconds."""
        self._stamp = stamp
        self._step_us: float | None = None
        self._is_counting: bool | None = None if seq == 0 else True
        self._recent = {seq: stamp}

    @property
    def is_counting(self) -> bool:
        """Whether the writer numbers its messages, as far as is known."""
        return bool(self._is_counting)

    def is_twin(self, seq: int, stamp: int) -> bool:
        """Return whether another writer sent ``seq``: this one has sent the number with another stamp."""
        return self.is_counting and self._recent.get(seq, stamp) != stamp

    def continues(self, seq: int, arrival_s: float, period_s: float | None) -> bool:
        """Return whether ``seq`` continues the stream, allowing for losses within the elapsed time."""
        if seq == 0 and self.seq == 0 and not self._is_counting:
            return True
        if self._is_counting is False:
            return False
        elapsed_s = arrival_s - self.arrival_s
        return 0 < seq - self.seq <= _MAX_LOST + 2 * elapsed_s / (period_s or _UNKNOWN_PERIOD_S)

    def is_echo(self, seq: int) -> bool:
        """Return whether ``seq`` is one of the last 30: a duplicate, or a message overtaken in the network."""
        return 0 <= self.seq - seq <= _MAX_LOST

    def error_us(self, seq: int, stamp: int) -> float:
        """Return the deviation of a stamp from the extrapolated one, infinite if unknown."""
        if self._step_us is None:
            return math.inf
        return abs(stamp - self._stamp - (seq - self.seq) * self._step_us)

    def add(self, seq: int, stamp: int, arrival_s: float) -> None:
        """Add the next message of the stream."""
        self._is_counting = seq != self.seq
        self._step_us = (stamp - self._stamp) / max(1, seq - self.seq)
        self.seq, self._stamp, self.arrival_s = seq, stamp, arrival_s
        self._recent[seq] = stamp
        if len(self._recent) > _MAX_LOST:
            del self._recent[next(iter(self._recent))]


class Candidate:
    """Consecutive messages that agree with each other: their stamps advance as much as their arrivals."""

    def __init__(self, stamp: int, arrival_s: float, delay_s: float) -> None:
        self.count = 1
        self.stamp = stamp
        self.arrival_s = arrival_s
        self.min_delay_s = delay_s

    def add(self, stamp: int, arrival_s: float, delay_s: float, tolerance_s: float) -> None:
        """Add the next message; one that does not agree within ``tolerance_s`` restarts the timeline."""
        advance_s = (stamp - self.stamp) / 1e6
        if advance_s > 0 and abs(advance_s - (arrival_s - self.arrival_s)) <= tolerance_s:
            self.count += 1
            self.min_delay_s = min(self.min_delay_s, delay_s)
        else:
            self.count, self.min_delay_s = 1, delay_s
        self.stamp, self.arrival_s = stamp, arrival_s
