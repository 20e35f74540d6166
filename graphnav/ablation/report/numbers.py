"""Numbers as the report writes them: no more digits than their intervals bear."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

_MOST_DECIMALS = 5
MINUS = "\N{MINUS SIGN}"


def number(value: float, decimals: int) -> str:
    """Return a number with so many decimals, zero without a sign."""
    text = f"{value:.{decimals}f}"
    return text.removeprefix("-") if float(text) == 0 else text.replace("-", MINUS)


def decimals_of(mean: float, low: float, high: float) -> int:
    """Return how many decimals a mean is worth: two digits of its interval's width, else three of itself."""
    width = high - low
    if math.isfinite(width) and width > 0:
        return min(max(1 - math.floor(math.log10(width)), 0), _MOST_DECIMALS)
    return 0 if mean == 0 else min(max(2 - math.floor(math.log10(abs(mean))), 0), _MOST_DECIMALS)


def estimated(mean: float, low: float, high: float, *, signed: bool = False) -> str:
    """Return ``0.94 [0.84, 0.98]``; without an interval the mean alone."""
    decimals = decimals_of(mean, low, high)
    sign = "+" if signed and float(f"{mean:.{decimals}f}") > 0 else ""
    text = sign + number(mean, decimals)
    if not (math.isfinite(low) and math.isfinite(high)):
        return text
    return f"{text} [{number(low, decimals)}, {number(high, decimals)}]"


def seeds_text(seeds: Sequence[int]) -> str:
    """Return seeds as ranges: ``1000 to 1049``."""
    if not seeds:
        return "none"
    breaks = [place for place, (one, next_one) in enumerate(pairwise(seeds), 1) if next_one != one + 1]
    runs = [seeds[begin:end] for begin, end in pairwise([0, *breaks, len(seeds)])]
    return ", ".join(f"{run[0]}" if len(run) == 1 else f"{run[0]} to {run[-1]}" for run in runs)


def counted(n: int, one: str, many: str = "") -> str:
    """Return ``1 world``, ``2 worlds``."""
    return f"{n} {one if n == 1 else many or one + 's'}"
