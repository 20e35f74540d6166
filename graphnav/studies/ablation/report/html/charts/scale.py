"""Scales of charts: range, ticks, and the pixel of a value."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

from graphnav.studies.ablation.report.html.rendering import number

_STEPS = (1, 2, 2.5, 5, 10)
_FLAT = 1e-9
"""A range of at most this share of the largest absolute value, or of 1, counts as zero."""
_WIDE = 100.0
"""An axis is logarithmic if its maximum is at least this many times its minimum."""
_NOISE = 1e-4
"""By how much of the range a value may lie outside the last tick; intervals are rounded to single precision."""


@dataclass(frozen=True)
class PlacedTick:
    """A tick of an axis: its pixel and its number."""

    at: float
    text: str


@dataclass(frozen=True)
class Scale:
    """A linear or logarithmic axis from ``low`` to ``high``, drawn from ``start`` to ``stop`` in pixels."""

    low: float
    high: float
    ticks: tuple[float, ...]
    decimals: int
    start: float
    stop: float
    is_log: bool = False

    def at(self, value: float) -> float:
        """Return where a value is; what is outside is at the end."""
        ends = [self.low, min(max(value, self.low), self.high), self.high]
        low, inside, high = map(math.log10, ends) if self.is_log else ends
        share = (inside - low) / (high - low)
        return self.start + share * (self.stop - self.start)

    @property
    def middle(self) -> float:
        """The pixel of the middle, where the axis' title is."""
        return (self.start + self.stop) / 2

    def placed_ticks(self) -> list[PlacedTick]:
        """Return all ticks."""
        return [PlacedTick(self.at(tick), self.label(tick)) for tick in self.ticks]

    def label(self, tick: float) -> str:
        """Return the number of a tick; ``≤`` precedes the lower end of a logarithmic axis, which holds all below."""
        if self.is_log:
            return f"≤{tick:g}" if tick == self.low else f"{tick:g}"
        return number(tick, f".{self.decimals}f")

    def between(self, start: float, stop: float) -> Scale:
        """Return the same axis drawn elsewhere."""
        return replace(self, start=start, stop=stop)


def scale_of(values: Iterable[float], max_ticks: int = 5) -> Scale:
    """Return an axis with round ticks that shows all finite values; between 0 and 1 where shares fill half of that."""
    finite = [value for value in values if math.isfinite(value)] or [0.0, 1.0]
    low, high = min(finite), max(finite)
    if low >= -_NOISE and 0.5 <= high <= 1.0 and high - low >= 0.4:
        low, high = 0.0, 1.0
    size = max(abs(low), abs(high))
    if high - low <= _FLAT * max(size, 1.0):
        half = 0.5 * size if size > _FLAT else 0.5
        low, high = low - half, high + half
    margin = _NOISE * (high - low)
    ticks = _even_ticks(low + margin, high - margin, max_ticks)
    decimals = max(len(f"{tick:.10f}".rstrip("0").partition(".")[2]) for tick in ticks)
    return Scale(ticks[0], ticks[-1], ticks, decimals, 0.0, 1.0)


def wide_scale_of(values: Iterable[float]) -> Scale:
    """Return the axis of `scale_of`, or a logarithmic one where only the largest values would be visible on it.

    Zeros have no place on a logarithmic axis; they are drawn at its lower end. What never exceeds 1 is taken for a
    share, of which small values are small.
    """
    finite = [value for value in values if math.isfinite(value)]
    positive = [value for value in finite if value > 0]
    if not positive or min(finite) < 0 or max(positive) < max(1.0, _WIDE * min(positive)):
        return scale_of(finite)
    ticks = _decade_ticks(min(positive), max(positive))
    return Scale(ticks[0], ticks[-1], ticks, 0, 0.0, 1.0, is_log=True)


def _even_ticks(low: float, high: float, max_ticks: int) -> tuple[float, ...]:
    """Return round numbers at equal distances from ``low`` or below to ``high`` or above."""
    from matplotlib.ticker import MaxNLocator

    locator = MaxNLocator(nbins=max_ticks, steps=_STEPS)
    return tuple(round(float(tick), 12) for tick in locator.tick_values(low, high))


def _decade_ticks(low: float, high: float) -> tuple[float, ...]:
    """Return 1, 3, 10, 30 and so on from ``low`` or below to ``high`` or above."""
    from matplotlib.ticker import LogLocator

    ticks = [float(f"{tick:.0e}") for tick in LogLocator(subs=(1, 3)).tick_values(low, 10 * high)]
    first = max(place for place, tick in enumerate(ticks) if tick <= low * (1 + _FLAT))
    last = min(place for place, tick in enumerate(ticks) if tick >= high * (1 - _FLAT))
    return tuple(ticks[first : last + 1])
