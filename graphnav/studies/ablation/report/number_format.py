"""Numbers of tables, with as many digits as their intervals allow."""

from __future__ import annotations

import math

from graphnav.studies.ablation.results import Difference, Estimate

MAX_DECIMALS = 4
MIN_P = 0.0001
"""Smaller p-values are shown as below it."""
APPROXIMATE = "≈"
"""Before an interval that is short of 95 % where the metric is skewed."""
TOO_SMALL = "smaller than what matters"
"""Of a significant difference."""
TINY = ".1e"
"""The format of numbers that have only zeros in so many decimals."""


def format_of(mean: float, low: float, high: float) -> str:
    """Return the format that shows two digits of half the interval's width; of the mean, four, where it has none.

    It has at most four decimals, unless they would all be zero: a mean is shown as zero only if its interval contains
    zero and a bound is not shown as zero.
    """
    half = (high - low) / 2
    size, digits = (half, 2) if math.isfinite(half) and half > 0 else (abs(mean), 4)
    if size == 0:
        return ".2f"
    fewest = min(max(digits - 1 - math.floor(math.log10(size)), 0), MAX_DECIMALS)
    told = (mean, low, high) if low <= 0 <= high else (mean,)
    for places in range(fewest, MAX_DECIMALS + 1):
        if any(abs(value) >= 10.0**-places for value in told):
            return f".{places}f"
    return TINY


def number(value: float, form: str, sign: str = "") -> str:
    """Return a number in a format, with ``sign`` where it is above zero; zero has none."""
    text = f"{value:{sign}{form}}"
    return text if float(text) else f"{0:{form}}".removesuffix("e+00")


def estimate_text(found: Estimate, worlds: int) -> str:
    """Return ``mean [low, high]``, and how many worlds had the metric where not all of ``worlds`` have."""
    form = format_of(found.mean, found.low, found.high)
    text = " ".join(
        [number(found.mean, form), *_interval(found.low, found.high, form, is_approximate=found.is_approximate)]
    )
    return text if found.n == worlds else f"{text} (n {found.n})"


def difference_text(found: Difference) -> str:
    """Return ``+mean [low, high], won-tied-lost``, and what decides also its p-value in the family."""
    form = format_of(found.mean, found.low, found.high)
    numbers = [number(found.mean, form, sign="+"), *_interval(found.low, found.high, form, sign="+")]
    text = f"{' '.join(numbers)}, {found.won}–{found.tied}–{found.lost}"
    if found.significance is None:
        return text
    text = f"{text}, {p_text(found.significance.p_holm)}"
    return f"{text}, {TOO_SMALL}" if found.is_significant and not found.matters else text


def p_text(p: float) -> str:
    """Return ``p 0.031``, or that it is below what matters to anyone."""
    return f"p < {MIN_P:g}" if p < MIN_P else f"p {float(f'{p:.2g}'):g}"


def _interval(low: float, high: float, form: str, sign: str = "", *, is_approximate: bool = False) -> list[str]:
    """Return the interval, or nothing where it is not known."""
    if math.isnan(low):
        return []
    return [f"{APPROXIMATE if is_approximate else ''}[{number(low, form, sign)}, {number(high, form, sign)}]"]
