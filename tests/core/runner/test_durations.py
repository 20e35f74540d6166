"""Quantiles of durations, of which any number takes the same memory."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from graphnav.core.runner.durations import Durations


def of(values: np.ndarray) -> Durations:
    """Return durations that were added one by one."""
    durations = Durations()
    for value in values.tolist():
        durations.add(value)
    return durations


@pytest.mark.parametrize("count", [1, 7, 256, 1000])
def test_quantiles_are_those_of_the_values(count: int) -> None:
    values = np.random.default_rng(count).lognormal(-6, 1, count)
    durations = of(values)
    assert durations.count == count
    assert durations.total_s == pytest.approx(values.sum())
    for share in (0.0, 0.5, 0.99, 1.0):
        expected = np.quantile(values, share, method="inverted_cdf")
        assert durations.quantile_s(share) == pytest.approx(expected, rel=0.012)


def test_a_quantile_may_be_asked_at_any_time() -> None:
    durations = of(np.full(10, 1e-3))
    assert durations.quantile_s(0.5) == pytest.approx(1e-3, rel=0.012)
    for _ in range(30):
        durations.add(1.0)
    assert durations.quantile_s(0.5) == pytest.approx(1.0, rel=0.012)


def test_extremes_are_counted_at_the_ends() -> None:
    assert of(np.array([0.0, 0.0])).quantile_s(0.5) == pytest.approx(1e-7, rel=0.012)
    assert of(np.array([1e6])).quantile_s(0.5) == pytest.approx(100, rel=0.012)
    assert Durations().quantile_s(0.5) == 0


def test_memory_does_not_grow() -> None:
    def size(durations: Durations) -> int:
        return sum(sys.getsizeof(value) for value in vars(durations).values())

    assert size(of(np.full(10_000, 1e-3))) <= size(of(np.full(300, 1e-3))) + 4096
