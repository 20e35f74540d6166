"""Intervals against scipy, published numbers and what they promise."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
import scipy.stats

from graphnav.studies.ablation.results.statistics import (
    bonett_price,
    difference_interval,
    mean_interval,
    student,
    wilson,
)

DRAW: dict[str, Callable[[np.random.Generator, int], np.ndarray]] = {
    "normal": lambda rng, n: rng.normal(3.0, 2.0, n),
    "exponential": lambda rng, n: rng.exponential(5.0, n),
    "share": lambda rng, n: rng.beta(8.0, 1.0, n),
}


@pytest.mark.parametrize("kind", DRAW)
@pytest.mark.parametrize("n", [2, 6, 20, 300])
def test_student_is_scipys(kind: str, n: int) -> None:
    values = DRAW[kind](np.random.default_rng(n), n)
    theirs = scipy.stats.ttest_1samp(values, 0.0).confidence_interval(0.95)
    assert student(values) == pytest.approx((theirs.low, theirs.high), rel=1e-12)


def test_students_own_example() -> None:
    # Student (1908), section IX: additional hours of sleep of ten patients by the one drug and the other; the interval
    # of the difference is that of R's t.test(sleep$extra[11:20], sleep$extra[1:10], paired = TRUE).
    dextro = np.array([0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0])
    laevo = np.array([1.9, 0.8, 1.1, 0.1, -0.1, 4.4, 5.5, 1.6, 4.6, 3.4])
    assert difference_interval(laevo, dextro, is_binary=False) == pytest.approx((0.7001142, 2.4598858), abs=1e-7)


def test_student_of_few_or_equal_values() -> None:
    assert all(map(math.isnan, student(np.array([0.7]))))
    assert student(np.full(50, 0.1)) == (0.1, 0.1)


def test_student_moves_and_grows_with_the_values() -> None:
    values = np.random.default_rng(0).exponential(1.0, 40)
    low, high = student(values)
    assert student(1000.0 + 7.0 * values) == pytest.approx((1000.0 + 7.0 * low, 1000.0 + 7.0 * high), rel=1e-12)


# R. G. Newcombe, Two-sided confidence intervals for the single proportion, Statistics in Medicine 17, 1998, table I.
@pytest.mark.parametrize(
    ("successes", "n", "low", "high"),
    [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)],
)
def test_wilson_is_as_published(successes: int, n: int, low: float, high: float) -> None:
    assert wilson(successes, n) == pytest.approx((low, high), abs=5e-5)


@pytest.mark.parametrize("n", [1, 2, 7, 50, 1000])
def test_wilson_is_scipys(n: int) -> None:
    for successes in range(0, n + 1, max(1, n // 7)):
        theirs = scipy.stats.binomtest(successes, n).proportion_ci(method="wilson")
        assert wilson(successes, n) == pytest.approx((theirs.low, theirs.high), abs=1e-12)


# The R packages statpsych, in its example of ci.prop.ps, and contingencytables, in its test of
# Wald_CI_BonettPrice_paired_2x2 with the table (59, 6; 16, 80), to four decimals.
@pytest.mark.parametrize(
    ("only_this", "only_base", "n", "low", "high", "error"),
    [(26, 4, 48, 0.2548067, 0.6251933, 5e-8), (6, 16, 161, -0.1195, -0.0032, 5e-5)],
)
def test_bonett_price_is_that_of_other_programs(
    only_this: int, only_base: int, n: int, low: float, high: float, error: float
) -> None:
    assert bonett_price(only_this, only_base, n) == pytest.approx((low, high), abs=error)


def test_bonett_price_changes_sides_with_the_two() -> None:
    low, high = bonett_price(3, 11, 50)
    assert bonett_price(11, 3, 50) == pytest.approx((-high, -low))


def test_where_nothing_differs_the_interval_still_has_a_width() -> None:
    ones = np.ones(50)
    low, high = difference_interval(ones, ones, is_binary=True)
    assert (low, high) == pytest.approx((-0.0533, 0.0533), abs=1e-4)
    low, high = mean_interval(ones, is_binary=True)
    assert low == pytest.approx(0.9287, abs=1e-4)
    assert high == 1.0


@pytest.mark.parametrize(("this", "base"), [(0.02, 0.02), (0.1, 0.02), (0.3, 0.1), (0.5, 0.2)])
def test_bonett_price_covers_the_true_difference(this: float, base: float) -> None:
    # The true shares of worlds in which only one of the two has it; summed over every outcome of 50 worlds.
    n = 50
    cells = scipy.stats.multinomial(n, [this, base, 1 - this - base])
    covered = 0.0
    for only_this in range(n + 1):
        for only_base in range(n + 1 - only_this):
            low, high = bonett_price(only_this, only_base, n)
            if low <= this - base <= high:
                covered += float(cells.pmf([only_this, only_base, n - only_this - only_base]))
    # Outcomes are integers, so that no interval covers exactly 95 %; with few differences this one covers more.
    assert covered >= 0.94


def test_intervals_hold_their_estimate() -> None:
    for n in (1, 3, 50):
        for k in range(n + 1):
            low, high = wilson(k, n)
            assert 0.0 <= low <= k / n <= high <= 1.0
            for j in range(n + 1 - k):
                low, high = bonett_price(k, j, n)
                assert -1.0 <= low <= (k - j) / n <= high <= 1.0
