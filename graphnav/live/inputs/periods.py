"""Estimate the typical period of a stream and its rate, in constant memory."""

from __future__ import annotations

from collections import deque
from statistics import median

from graphnav.core.record import Window, silent_after_s

_KEPT = 9
_MIN_KNOWN = 3
_KEPT_ARRIVALS = 20


class Periods:
    """The median of the last 9 increments of the stamps, and the rate of the last 20 arrivals."""

    def __init__(self) -> None:
        self.usual_s: float | None = None
        """The typical period in seconds, None before 3 increments are known."""
        self._increments: deque[float] = deque(maxlen=_KEPT)
        self._arrivals = Window(None, _KEPT_ARRIVALS)
        self._n_arrived = 0

    def add(self, increment_s: float) -> None:
        """Add an increment of the stamps in seconds."""
        self._increments.append(increment_s)
        if len(self._increments) >= _MIN_KNOWN:
            self.usual_s = median(self._increments)

    def arrive(self, arrival_s: float, *, is_restart: bool) -> None:
        """Add an arrival (monotonic seconds); the rate does not include arrivals before a restart."""
        if is_restart:
            self._arrivals = Window(None, _KEPT_ARRIVALS)
        self._n_arrived += 1
        self._arrivals.add(arrival_s, arrival_s, self._n_arrived)

    def forget(self) -> None:
        """Start over: another writer has another period."""
        self._increments.clear()
        self.usual_s = None

    def rate_hz(self, now_s: float, max_age_s: float) -> float:
        """Return arrivals per second; 0 after a silence of ``max_age_s`` and 3 periods."""
        if self._arrivals.is_empty or now_s - self._arrivals.newest_s > silent_after_s(self.usual_s, max_age_s):
            return 0.0
        return self._arrivals.rate_hz() or 0.0
