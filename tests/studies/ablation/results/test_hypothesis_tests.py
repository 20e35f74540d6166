"""Tests of paired differences against scipy, enumeration and published numbers."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
import scipy.stats

from graphnav.studies.ablation.results.statistics import (
    EXACT_BELOW,
    holm,
    mcnemar,
    min_worlds,
    p_value,
    sign_flip,
    t_test,
)


@pytest.mark.parametrize("n", [1, 2, 3, 6, 11])
def test_the_sign_flip_test_counts_all_signs(n: int) -> None:
    differences = np.random.default_rng(n).normal(0.4, 1.0, n)
    sums = [abs(float(np.dot(signs, differences))) for signs in product((-1, 1), repeat=n)]
    far = sum(total >= abs(float(differences.sum())) - 1e-12 for total in sums)
    assert sign_flip(differences) == far / 2**n


def test_the_sign_flip_test_is_scipys() -> None:
    differences = np.random.default_rng(1).exponential(1.0, 12) - 0.6
    theirs = scipy.stats.permutation_test(
        (differences,), np.mean, permutation_type="samples", n_resamples=np.inf, vectorized=True
    )
    assert sign_flip(differences) == pytest.approx(theirs.pvalue, abs=1e-12)


def test_darwins_maize() -> None:
    # R. A. Fisher, The Design of Experiments, section 21: of 2^15 sums, 863 are as large and 835 larger in one tail.
    eighths = np.array([49, -67, 8, 16, 6, 23, 28, 41, 14, 29, 56, 24, 75, 60, -48]) / 8
    assert sign_flip(eighths) * 2**15 == 2 * 863


def test_worlds_that_are_alike_and_rounding_do_not_count() -> None:
    tenths = np.array([0.1, 0.2, -0.3, 0.0, 0.0])
    assert sign_flip(tenths) == 1.0, "the sum is 0 on paper"
    assert sign_flip(np.array([0.3, 0.1, 0.2, -0.1])) == sign_flip(np.array([3.0, 1.0, 2.0, -1.0]))
    assert sign_flip(np.zeros(7)) == 1.0


def test_the_smallest_p_value_is_two_in_two_to_the_number_of_worlds() -> None:
    for n in (6, EXACT_BELOW - 1):
        assert sign_flip(np.arange(1.0, n + 1)) == 2 / 2**n


@pytest.mark.parametrize(("this", "base"), [(0, 0), (6, 0), (3, 11), (25, 25), (40, 20)])
def test_mcnemar_is_the_binomial_test(this: int, base: int) -> None:
    theirs = scipy.stats.binomtest(this, this + base).pvalue if this + base else 1.0
    assert mcnemar(this, base) == pytest.approx(theirs, rel=1e-9)


def test_mcnemar_is_the_sign_flip_test_of_zeros_and_ones() -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        this, base = rng.integers(0, 2, (2, 15)).astype(float)
        assert p_value(this, base, is_binary=True) == p_value(this, base, is_binary=False)


@pytest.mark.parametrize("n", [20, 50])
def test_the_t_test_is_scipys(n: int) -> None:
    rng = np.random.default_rng(n)
    this, base = rng.normal(0.3, 1.0, n), rng.exponential(1.0, n)
    assert p_value(this, base, is_binary=False) == pytest.approx(scipy.stats.ttest_rel(this, base).pvalue, rel=1e-9)


def test_the_t_test_of_equal_differences() -> None:
    assert t_test(np.zeros(30)) == 1.0
    assert t_test(np.full(30, 0.2)) == 0.0


def test_holm_steps_down() -> None:
    # Worked by hand: 4 x 0.005, 3 x 0.01, 2 x 0.03, and 1 x 0.04, which may not be less than the one before.
    p_values = [0.01, 0.04, 0.03, 0.005]
    assert [test.p_holm for test in holm(p_values, 4)] == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert [test.family for test in holm(p_values, 4)] == [4] * 4


def test_comparisons_without_runs_count_in_the_family() -> None:
    assert [test.p_holm for test in holm([0.01, 0.02], 5)] == pytest.approx([0.05, 0.08])
    assert holm([], 3) == []


@pytest.mark.parametrize(("family", "worlds"), [(0, 6), (1, 6), (2, 7), (17, 10), (153, 13)])
def test_how_many_worlds_a_family_takes(family: int, worlds: int) -> None:
    assert min_worlds(family) == worlds
    # All worlds speak for one side: so many suffice, and one less does not.
    assert holm([2 / 2**worlds], max(family, 1))[0].is_significant
    assert not holm([2 / 2 ** (worlds - 1)], max(family, 1))[0].is_significant
