"""Axes of charts: which range, where the ticks are, where a value is."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

_STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)
_FLAT = 1e-9
"""A range that is no larger, of the values or of 1, is none."""
_NOISE = 1e-4
"""By how much of a step a value may pass a tick that stands for it; intervals are rounded to single precision."""


@dataclass(frozen=True)
class Scale:
    """A linear axis from ``low`` to ``high``, drawn from ``start`` to ``stop`` in pixels."""

    low: float
    high: float
    ticks: tuple[float, ...]
    decimals: int
    start: float
    stop: float

    def at(self, value: float) -> float:
        """Return where a value is; what is outside is at the end."""
        share = (min(max(value, self.low), self.high) - self.low) / (self.high - self.low)
        return self.start + share * (self.stop - self.start)

    def between(self, start: float, stop: float) -> Scale:
        """Return the same axis drawn elsewhere."""
        return Scale(self.low, self.high, self.ticks, self.decimals, start, stop)


def scale_of(values: Iterable[float], most_ticks: int = 5) -> Scale:
    """Return an axis with round ticks that shows all finite values; between 0 and 1 where shares fill half of that."""
    finite = [value for value in values if math.isfinite(value)] or [0.0, 1.0]
    low, high = min(finite), max(finite)
    if low >= -_NOISE and 0.5 <= high <= 1.0 and high - low >= 0.4:
        low, high = 0.0, 1.0
    size = max(abs(low), abs(high))
    if high - low <= _FLAT * max(size, 1.0):
        half = 0.5 * size if size > _FLAT else 0.5
        low, high = low - half, high + half
    step = _step((high - low) / most_ticks)
    first, last = math.floor(low / step + _NOISE), math.ceil(high / step - _NOISE)
    ticks = tuple(round(number * step, 12) for number in range(first, last + 1))
    decimals = max(len(f"{tick:.10f}".rstrip("0").partition(".")[2]) for tick in ticks)
    return Scale(ticks[0], ticks[-1], ticks, decimals, 0.0, 1.0)


def _step(least: float) -> float:
    """Return the round number that is at least so large."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(power * step for step in _STEPS if power * step >= least * (1 - 1e-9))
