"""Messages on their way from whoever receives them to whoever shows them: bounded, the oldest give way."""

from __future__ import annotations

import threading
from collections import deque
from typing import NamedTuple

_MAX_BYTES = 32 << 20
_PER_MESSAGE_BYTES = 256
"""What the queue itself needs of each message."""


class Arrival(NamedTuple):
    """A message; ``utime``: when it arrived, or where in the log it is, microseconds.

    ``is_past``: it only counts for what is drawn later, as the poses of the path behind the robot.
    """

    channel: str
    utime: int
    data: bytes
    is_past: bool = False

    @property
    def n_bytes(self) -> int:
        """What it takes in memory."""
        return len(self.data) + _PER_MESSAGE_BYTES


class Batch(NamedTuple):
    """What came since the last time; ``is_jump``: at another place of the log than what came before.

    ``n_dropped``: messages that came too fast to be kept.
    """

    arrivals: list[Arrival]
    is_jump: bool
    n_dropped: int


class Arrivals:
    """A queue of 32 MB between two threads."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._waiting: deque[Arrival] = deque()
        self._n_bytes = self._n_dropped = 0
        self._is_jump = False

    def put(self, arrival: Arrival) -> None:
        """Hand over a message; returns at once."""
        with self._changed:
            self._append(arrival)
            self._changed.notify()

    def jump(self, arrivals: list[Arrival]) -> None:
        """Forget what waits, and go on from another place of the log, where these are what was said before."""
        with self._changed:
            self._waiting.clear()
            self._n_bytes = 0
            self._is_jump = True
            for arrival in arrivals:
                self._append(arrival)
            self._changed.notify()

    def take(self, timeout_s: float) -> Batch:
        """Return all that waits, after waiting for something."""
        with self._changed:
            if not self._waiting and not self._is_jump:
                self._changed.wait(timeout_s)
            batch = Batch(list(self._waiting), self._is_jump, self._n_dropped)
            self._waiting.clear()
            self._n_bytes = self._n_dropped = 0
            self._is_jump = False
            return batch

    def wake(self) -> None:
        """Let whoever waits for messages look at what else there is to do."""
        with self._changed:
            self._changed.notify()

    def _append(self, arrival: Arrival) -> None:
        self._waiting.append(arrival)
        self._n_bytes += arrival.n_bytes
        while self._n_bytes > _MAX_BYTES:
            self._n_bytes -= self._waiting.popleft().n_bytes
            self._n_dropped += 1
