"""Wall-clock timers of sources and timed stages."""

from __future__ import annotations

import math


class Timer:
    """Due at ``start_s`` and every ``period_s`` after it; missed firings are counted, not made up for."""

    def __init__(self, period_s: float, start_s: float) -> None:
        self.due_s = start_s
        self.skipped = 0
        self._period_s, self._start_s = period_s, start_s
        self._count = 0

    def is_due(self, now_s: float) -> bool:
        """Whether the timer is due."""
        return now_s >= self.due_s

    def advance(self, now_s: float) -> None:
        """Schedule the next firing; skip those that are late by more than a period."""
        following = max(self._count + 1, math.floor((now_s - self._start_s) / self._period_s))
        self.skipped += following - self._count - 1
        self._count = following
        self.due_s = self._start_s + following * self._period_s
