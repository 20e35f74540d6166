"""Intervals at 95 % for means over worlds and for differences between runs in the same worlds."""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from graphnav.arrays import Doubles

LEVEL = 0.95
"""Of all intervals."""
Z = 1.959963984540054
"""The normal distribution's 97.5 % quantile."""


class Interval(NamedTuple):
    """Bounds; not a number where there are too few worlds."""

    low: float
    high: float


def mean_interval(values: Doubles, *, is_binary: bool) -> Interval:
    """Return the interval of a mean over worlds: Wilson's for metrics that are 0 or 1, else Student's."""
    return wilson(float(values.sum()), values.size) if is_binary else student(values)


def difference_interval(values: Doubles, base: Doubles, *, is_binary: bool) -> Interval:
    """Return the interval of the mean of ``values - base``, world by world: Bonett and Price's, or Student's.

    ``is_binary``: whether all are 0 or 1.
    """
    if not is_binary:
        return student(values - base)
    return bonett_price(int(np.count_nonzero(values > base)), int(np.count_nonzero(values < base)), values.size)


def student(values: Doubles) -> Interval:
    """Return Student's t interval of the mean [Student].

    Exact for normal values. Differences of two equal distributions are symmetric, however skewed these are; there it
    covers at least as much as it promises. Of single skewed values it covers less.
    Not a number for fewer than two values; of equal values it has no width.

    References
    ----------
    .. [Student] Student, The Probable Error of a Mean, Biometrika 6(1), 1908.
    """
    n, mean = values.size, float(values.mean())
    if n < 2:
        return Interval(math.nan, math.nan)
    if values.min() == values.max():
        return Interval(float(values[0]), float(values[0]))
    half = t_quantile(n - 1) * float(values.std(ddof=1)) / math.sqrt(n)
    return Interval(mean - half, mean + half)


@cache
def t_quantile(degrees: int) -> float:
    """Return the 97.5 % quantile of Student's distribution."""
    from scipy.special import stdtrit

    return float(stdtrit(degrees, (1 + LEVEL) / 2))


def wilson(successes: float, n: int) -> Interval:
    """Return Wilson's score interval of a share, which has a width also where all worlds agree [Wilson].

    References
    ----------
    .. [Wilson] E. B. Wilson, Probable Inference, the Law of Succession, and Statistical Inference, Journal of the
       American Statistical Association 22, 1927; recommended by L. D. Brown et al., Statistical Science 16(2), 2001.
    """
    share, spread = successes / n, 2 * (n + Z**2)
    middle = (2 * successes + Z**2) / spread
    half = Z * math.sqrt(4 * successes * (1 - share) + Z**2) / spread
    return Interval(0.0 if successes == 0 else middle - half, 1.0 if successes == n else middle + half)


def bonett_price(only_this: int, only_base: int, n: int) -> Interval:
    """Return the adjusted Wald interval of the difference of two shares in the same ``n`` worlds [Bonett].

    ``only_this``, ``only_base``: in how many worlds one has it and the other has not. It has a width also where no
    world tells them apart.

    References
    ----------
    .. [Bonett] D. G. Bonett, R. M. Price, Adjusted Wald Confidence Interval for a Difference of Binomial Proportions
       Based on Paired Data, Journal of Educational and Behavioral Statistics 37(4), 2012; recommended by
       M. W. Fagerland et al., Statistics in Medicine 33(16), 2014.
    """
    this, base = (only_this + 1) / (n + 2), (only_base + 1) / (n + 2)
    half = Z * math.sqrt((this + base - (this - base) ** 2) / (n + 2))
    return Interval(max(this - base - half, -1.0), min(this - base + half, 1.0))
