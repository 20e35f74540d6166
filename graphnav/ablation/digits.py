"""Numbers of tables, with as many digits as their intervals allow."""

from __future__ import annotations

import math

from graphnav.ablation.comparison import Difference, Estimate

MOST_DECIMALS = 4


def decimals(mean: float, low: float, high: float) -> int:
    """Return how many decimals show two digits of half the interval's width; of the mean, four, where it has none."""
    half = (high - low) / 2
    size, digits = (half, 2) if math.isfinite(half) and half > 0 else (abs(mean), 4)
    if size == 0:
        return 2
    return min(max(digits - 1 - math.floor(math.log10(size)), 0), MOST_DECIMALS)


def estimate_text(found: Estimate, worlds: int) -> str:
    """Return ``mean [low, high]``, and how many worlds had the figure where not all of ``worlds`` have."""
    places = decimals(found.mean, found.low, found.high)
    text = " ".join([f"{_number(found.mean, places)}", *_interval(found.low, found.high, places)])
    return text if found.n == worlds else f"{text} (n {found.n})"


def difference_text(found: Difference) -> str:
    """Return ``+mean [low, high], won-lost``."""
    places = decimals(found.mean, found.low, found.high)
    numbers = [_number(found.mean, places, sign="+"), *_interval(found.low, found.high, places, sign="+")]
    return f"{' '.join(numbers)}, {found.won}–{found.lost}"


def _interval(low: float, high: float, places: int, sign: str = "") -> list[str]:
    """Return the interval, or nothing where it is not known."""
    if math.isnan(low):
        return []
    return [f"[{_number(low, places, sign)}, {_number(high, places, sign)}]"]


def _number(value: float, places: int, sign: str = "") -> str:
    rounded = round(value, places)
    return f"{rounded + 0.0:{sign if rounded else ''}.{places}f}"
