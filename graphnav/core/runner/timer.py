"""Wall-clock timers of sources and timed stages."""

from __future__ import annotations

import math
from collections.abc import Callable


class Timer:
    """Due at ``start_s`` and ``after_s(k)`` after it, k = 1, 2, ...; missed firings are counted, not made up for."""

    def __init__(self, after_s: Callable[[int], float], start_s: float) -> None:
        self.due_s = start_s
        self.skipped = 0
        self._after_s, self._start_s = after_s, start_s
        self._count = 0

    def is_due(self, now_s: float) -> bool:
        """Whether the timer is due."""
        return now_s >= self.due_s

    def advance(self, now_s: float) -> None:
        """Schedule the next firing; skip those after which another one is due already."""
        following, step = self._count + 1, 1
        while self._at_s(following + step) <= now_s:
            following += step
            step *= 2
        while step > 1:
            step //= 2
            if self._at_s(following + step) <= now_s:
                following += step
        self.skipped += following - self._count - 1
        self._count = following
        self.due_s = self._at_s(following)

    def _at_s(self, firing: int) -> float:
        return self._start_s + self._after_s(firing)

    @staticmethod
    def every(period_s: float) -> Callable[[int], float]:
        """Return the times of a timer with a constant period."""
        return lambda firing: firing * period_s


class ArrivalTimer(Timer):
    """Due when something has arrived: at the time at which it was taken, as ``arrived_s`` tells, which is None before.

    ``heard_s``: when that was last seen, else the start.
    """

    def __init__(self, arrived_s: Callable[[], float | None], start_s: float) -> None:
        super().__init__(lambda _: math.inf, math.inf)
        self.heard_s = start_s
        self._arrived_s = arrived_s

    def is_due(self, now_s: float) -> bool:
        """Whether something has arrived."""
        arrived_s = self._arrived_s()
        self.due_s = math.inf if arrived_s is None else arrived_s
        if arrived_s is not None:
            self.heard_s = now_s
        return arrived_s is not None

    def advance(self, now_s: float) -> None:  # noqa: ARG002 - it is told
        """Wait for what arrives next."""
        self.due_s = math.inf
