"""Intervals at 95 % for means over worlds and for differences between runs in the same worlds."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from graphnav.arrays import Doubles

DRAWS = 10_000
"""Resamples of the worlds in a bootstrap."""
SEED = 20_260
"""Of the resamples, so that a report that is made again is the same."""
NORMAL_FROM = 2000
"""Values in a bootstrap from which on nothing is drawn."""
_WORLDS_AT_ONCE = 2**18
"""Of all resamples that are drawn in one call: 2 MB."""
Z = 1.959963984540054
"""The normal distribution's 97.5 % quantile."""


class Interval(NamedTuple):
    """Bounds; not a number where there are too few worlds."""

    low: float
    high: float


def mean_interval(values: Doubles, *, is_binary: bool) -> Interval:
    """Return the interval of a mean over worlds: Wilson's for metrics that are 0 or 1, else the bootstrap's."""
    return wilson(float(values.sum()), values.size) if is_binary else bootstrap(values)


def difference_interval(values: Doubles, base: Doubles, *, is_binary: bool) -> Interval:
    """Return the interval of the mean of ``values - base``, world by world: Bonett and Price's, or the bootstrap's.

    ``is_binary``: whether all are 0 or 1. Resampling the worlds resamples both, so that the bootstrap of the pairs is
    that of their differences.
    """
    if not is_binary:
        return bootstrap(values - base)
    return bonett_price(int(np.count_nonzero(values > base)), int(np.count_nonzero(values < base)), values.size)


def bootstrap(values: Doubles) -> Interval:
    """Return the percentile bootstrap's interval of the mean [Efron].

    Not a number for fewer than two values. From `NORMAL_FROM` values on it is the
    normal distribution's, with the bootstrap's own spread: the resampled means are normal then.

    References
    ----------
    .. [Efron] B. Efron, R. J. Tibshirani, An Introduction to the Bootstrap, 1993, chapter 13.
    """
    n, mean = values.size, float(values.mean())
    if n < 2:
        return Interval(math.nan, math.nan)
    if values.min() == values.max():
        return Interval(float(values[0]), float(values[0]))
    if n >= NORMAL_FROM:
        half = Z * float(values.std()) / math.sqrt(n)
        return Interval(mean - half, mean + half)
    # Integer counts, not shares: a resample of zeros has a mean of exactly 0.
    means = np.einsum("ij,j->i", _resamples(n), values) / n
    low, high = np.quantile(means, [0.025, 0.975])
    return Interval(float(low), float(high))


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


@lru_cache(maxsize=8)
def _resamples(n: int) -> npt.NDArray[np.int16]:
    """Return how often each of ``n`` worlds is in each resample, (`DRAWS`, n); rows sum to n."""
    rng = np.random.default_rng(SEED)
    counts = np.empty((DRAWS, n), np.int16)
    at_once = max(1, _WORLDS_AT_ONCE // n)
    for first in range(0, DRAWS, at_once):
        part = counts[first : first + at_once]
        drawn = rng.integers(0, n, part.shape)
        drawn += np.arange(len(part))[:, None] * n
        part[:] = np.bincount(drawn.reshape(-1), minlength=part.size).reshape(part.shape)
    counts.setflags(write=False)
    return counts
