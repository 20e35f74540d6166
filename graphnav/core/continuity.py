"""Detect gaps in a stream of timestamps, after which a stage's memory is no longer valid."""

from __future__ import annotations

from statistics import median

from graphnav.core.stage import Stamp

MAX_PERIODS = 3.0
_KEPT = 9


class Continuity:
    """Tells a stage with memory when to reset it.

    A stream is broken by a timestamp that does not advance, and by a gap of more than ``max_periods`` times its period,
    the median of the last 9. Regular streams, as in lockstep, are never broken.
    """

    def __init__(self, max_periods: float = MAX_PERIODS) -> None:
        self._max_periods = max_periods
        self._last: int | None = None
        self._periods: list[int] = []

    def breaks(self, stamp: Stamp | int) -> bool:
        """Take the next timestamp; return whether the stream was broken before it, False for the first one."""
        last, self._last = self._last, int(stamp)
        if last is None:
            return False
        period = int(stamp) - last
        if period <= 0 or (self._periods and period > self._max_periods * median(self._periods)):
            self._periods.clear()
            return True
        self._periods = [*self._periods[-_KEPT + 1 :], period]
        return False
