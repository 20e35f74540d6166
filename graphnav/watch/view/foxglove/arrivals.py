"""A bounded queue of messages between the receive thread and the server; the oldest are dropped."""

from __future__ import annotations

import threading
from collections import deque
from typing import NamedTuple

from graphnav.watch.feed import Past, Received

_MAX_BYTES = 32 << 20
_PER_MESSAGE_BYTES = 256
"""Memory overhead of a queued message."""


class Arrival(NamedTuple):
    """A message; ``utime``: its arrival, or its time in the log, microseconds.

    ``is_past``: it is not shown itself, but used by later pictures, such as the poses of the robot's path.
    """

    channel: str
    utime: int
    data: bytes
    is_past: bool = False

    @property
    def n_bytes(self) -> int:
        """Its size in memory."""
        return len(self.data) + _PER_MESSAGE_BYTES


class Batch(NamedTuple):
    """The messages since the last batch; ``is_jump``: whether the log has jumped to another time.

    ``n_dropped``: messages dropped by the queue.
    """

    arrivals: list[Arrival]
    is_jump: bool
    n_dropped: int


class Arrivals:
    """A queue of 32 MB between two threads; ``epoch_us`` is added to the times of the feed."""

    epoch_us = 0

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._waiting: deque[Arrival] = deque()
        self._n_bytes = self._n_dropped = 0
        self._is_jump = False

    def put(self, received: Received) -> None:
        """Queue a message; returns immediately."""
        with self._changed:
            self._append(received)
            self._changed.notify()

    def jump(self, past: Past) -> None:
        """Clear the queue and continue at another time of the log, preceded by these earlier messages."""
        with self._changed:
            self._waiting.clear()
            self._n_bytes = 0
            self._is_jump = True
            for received in past.poses:
                self._append(received, is_past=True)
            for received in past.newest:
                self._append(received)
            self._changed.notify()

    def take(self, timeout_s: float) -> Batch:
        """Wait for messages and return all of them."""
        with self._changed:
            if not self._waiting and not self._is_jump:
                self._changed.wait(timeout_s)
            batch = Batch(list(self._waiting), self._is_jump, self._n_dropped)
            self._waiting.clear()
            self._n_bytes = self._n_dropped = 0
            self._is_jump = False
            return batch

    def wake(self) -> None:
        """Wake the thread that waits in `take`."""
        with self._changed:
            self._changed.notify()

    def _append(self, received: Received, *, is_past: bool = False) -> None:
        utime = self.epoch_us + round(received.at_s * 1e6)
        arrival = Arrival(received.channel, utime, received.data, is_past)
        self._waiting.append(arrival)
        self._n_bytes += arrival.n_bytes
        while self._n_bytes > _MAX_BYTES:
            self._n_bytes -= self._waiting.popleft().n_bytes
            self._n_dropped += 1
