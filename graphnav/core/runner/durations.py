"""Quantiles of many durations in constant memory."""

from __future__ import annotations

import math

_MIN_S = 1e-7
_PER_DECADE = 100
_BINS = 9 * _PER_DECADE
_MAX_UNCOUNTED = 256


class Durations:
    """A histogram of durations from 0.1 us to 100 s; the error of quantiles is at most 1.2 %."""

    def __init__(self) -> None:
        self._counts = [0] * _BINS
        self._uncounted: list[float] = []
        self.count = 0
        self.total_s = 0.0

    def add(self, duration_s: float) -> None:
        """Count one duration; the histogram is brought up to date later, many at once."""
        self.count += 1
        self.total_s += duration_s
        self._uncounted.append(duration_s)
        if len(self._uncounted) >= _MAX_UNCOUNTED:
            self._update()

    def quantile_s(self, share: float) -> float:
        """Return the ``share`` quantile (0 to 1) of the counted durations, 0 if there are none."""
        self._update()
        rank = share * self.count
        seen = 0
        for place, count in enumerate(self._counts):
            seen += count
            if count and seen >= rank:
                return float(_MIN_S * 10 ** ((place + 0.5) / _PER_DECADE))
        return 0.0

    def _update(self) -> None:
        for duration_s in self._uncounted:
            place = int(_PER_DECADE * math.log10(duration_s / _MIN_S)) if duration_s > _MIN_S else 0
            self._counts[min(place, _BINS - 1)] += 1
        self._uncounted.clear()
