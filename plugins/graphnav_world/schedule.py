"""Firing times of a sensor."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


class Schedule:
    """Times at a rate, microseconds from 0 on, each but the first off its nominal time by at most a jitter.

    ``jitter_s``: below half a period, so that the order stays; ``seed`` draws it uniformly to both sides.
    """

    def __init__(self, rate_hz: float, jitter_s: float = 0.0, seed: Sequence[int] = ()) -> None:
        self._rate_hz, self._jitter_s = rate_hz, jitter_s
        self._rng = np.random.default_rng(seed)
        self._count = 0
        self._next_us = 0

    def due(self, now_us: int) -> list[int]:
        """Return the times that have come since the last call, oldest first, each once."""
        times = []
        while self._next_us <= now_us:
            times.append(self._next_us)
            self._count += 1
            jitter_us = 1e6 * self._jitter_s * self._rng.uniform(-1.0, 1.0)
            self._next_us = round(1e6 * self._count / self._rate_hz + jitter_us)
        return times
