"""Intervals at 95 % and tests of means over worlds and of differences in the same worlds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
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


ALPHA = 0.05
"""The chance that at least one difference of a family is called clear where none is."""
EXACT_BELOW = 20
"""Worlds below which the distribution of the differences is not assumed to be anything."""


@dataclass(frozen=True)
class Significance:
    """The p-value of a comparison, adjusted for its family."""

    p_holm: float
    """The p-value, adjusted for the number of tests: where nothing differs, 1 family in 20 has one below `ALPHA`."""
    family: int
    """How many tests the family has."""

    @property
    def is_significant(self) -> bool:
        """Whether the difference is not by chance, with all others of the family considered."""
        return self.p_holm <= ALPHA

    @property
    def min_worlds(self) -> int:
        """How many worlds it takes that any test of the family can be significant."""
        return min_worlds(self.family)


def p_value(values: Doubles, base: Doubles, *, is_binary: bool) -> float:
    """Return the two-sided p-value of ``values - base``, world by world.

    The exact sign-flip test below `EXACT_BELOW` worlds, Student's t test from there on, and McNemar's exact test for
    metrics that are 0 or 1, whatever the number of worlds: it is their sign-flip test. 1 for a single world.
    """
    if is_binary:
        return mcnemar(int(np.count_nonzero(values > base)), int(np.count_nonzero(values < base)))
    return sign_flip(values - base) if values.size < EXACT_BELOW else t_test(values - base)


def sign_flip(differences: Doubles) -> float:
    """Return the exact randomisation test's p-value of the mean of paired differences [Fisher]_ [Pitman]_.

    If two variants are alike, each difference has either sign with the same chance. The p-value is the share of all
    ``2**n`` ways to choose the signs whose sum is as far from 0. The sums are counted as pairs of those of two halves,
    one of them sorted: for 19 worlds 512 searches in 1024 sums, 60 us.

    References
    ----------
    .. [Fisher] R. A. Fisher, The Design of Experiments, 1935, section 21.
    .. [Pitman] E. J. G. Pitman, Significance Tests Which May be Applied to Samples from any Populations, Supplement to
       the Journal of the Royal Statistical Society 4(1), 1937.
    """
    known = differences[differences != 0]
    if not known.size:
        return 1.0
    first, second = np.array_split(known, 2)
    ones, others = _signed_sums(first), np.sort(_signed_sums(second))
    # Sums that are equal by the numbers on paper may differ by rounding.
    observed = abs(float(known.sum())) - 1e-9 * float(np.abs(known).sum())
    n_above = int((others.size - np.searchsorted(others, observed - ones, side="left")).sum())
    return min(1.0, 2 * n_above / (1 << int(known.size)))


def mcnemar(only_this: int, only_base: int) -> float:
    """Return the exact McNemar test's p-value, from in how many worlds only one of the two has it [McNemar].

    References
    ----------
    .. [McNemar] Q. McNemar, Note on the Sampling Error of the Difference between Correlated Proportions or Percentages,
       Psychometrika 12(2), 1947.
    """
    n = only_this + only_base
    n_below = sum(math.comb(n, k) for k in range(min(only_this, only_base) + 1))
    return min(1.0, 2 * n_below / (1 << n))


def t_test(differences: Doubles) -> float:
    """Return the p-value of Student's t test of a mean of 0; of equal differences 0, or 1 where they are 0."""
    from scipy.special import stdtr

    if differences.min() == differences.max():
        return 0.0 if differences[0] else 1.0
    spread = float(differences.std(ddof=1)) / math.sqrt(differences.size)
    return float(2 * stdtr(differences.size - 1, -abs(float(differences.mean())) / spread))


def holm(p_values: Sequence[float], family: int) -> list[Significance]:
    """Return the p-values of one family, adjusted for the number of its tests by Holm's step-down procedure [Holm].

    ``family``: how many tests it has, with those that have no p-value yet: they count as 1.

    References
    ----------
    .. [Holm] S. Holm, A Simple Sequentially Rejective Multiple Test Procedure, Scandinavian Journal of Statistics 6(2),
       1979.
    """
    adjusted, largest = [1.0] * len(p_values), 0.0
    for rank, place in enumerate(sorted(range(len(p_values)), key=lambda k: p_values[k])):
        largest = max(largest, min(1.0, (family - rank) * p_values[place]))
        adjusted[place] = largest
    return [Significance(p_holm, family) for p_holm in adjusted]


def min_worlds(family: int) -> int:
    """Return how many worlds it takes that any of so many tests can be clear.

    The smallest p-value of an exact test is ``2 / 2**n``, where all n worlds speak for one side; from `EXACT_BELOW` on
    there is no such bound for metrics that are not 0 or 1.
    """
    return math.ceil(math.log2(2 * max(family, 1) / ALPHA))


def _signed_sums(values: Doubles) -> Doubles:
    """Return the sums of all choices of signs, ``2**n`` of them."""
    sums = np.zeros(1)
    for value in values:
        sums = np.concatenate([sums - value, sums + value])
    return sums


BETS = (np.arange(64) + 0.5) / 64
"""Shares of the wealth that are bet on each side; the evidence is the mean over all."""


def e_process(differences: Doubles) -> Doubles:
    """Return the evidence after each world, (..., n), that the mean of paired differences is not 0.

    ``differences``: (..., n), in [-1, 1], in the order of the worlds. The wealth of a bettor who starts with 1 and bets
    a fixed share of it that the next difference is above 0, or below, averaged over both sides and all shares [WSR].
    Where the mean is 0 the wealth is a fair game, however the differences are distributed: it ever reaches
    ``1 / level`` with a probability of at most ``level`` (Ville's inequality), however often it is looked at.

    References
    ----------
    .. [WSR] I. Waudby-Smith, A. Ramdas, Estimating Means of Bounded Random Variables by Betting, Journal of the Royal
       Statistical Society B 86(1), 2024.
    """
    wealth = np.zeros(differences.shape)
    for bet in BETS:
        for side in (bet, -bet):
            wealth += np.exp(np.minimum(np.cumsum(np.log1p(side * differences), axis=-1), _MAX_LOG))
    return wealth / (2 * BETS.size)


def anytime_p(differences: Doubles) -> float:
    """Return a p-value that holds whenever it is looked at, from paired differences in [-1, 1]; 1 without any.

    One over the most evidence so far: where the mean is 0, it is ever below ``level`` with a probability of at most
    ``level``.
    """
    return 1 / max(1.0, float(e_process(differences).max(initial=0.0)))


_MAX_LOG = 600.0
"""Keeps the wealth finite; it is decided long before."""
