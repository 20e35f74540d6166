"""The streaming receiver operating characteristic against scikit-learn's exact one."""

from __future__ import annotations

import hypothesis
import hypothesis.strategies as st
import numpy as np
import pytest
from graphnav_score.roc import Roc
from sklearn.metrics import roc_auc_score, roc_curve


def filled(score: np.ndarray, is_obstacle: np.ndarray, parts: int = 7) -> Roc:
    roc = Roc()
    for scores, truths in zip(np.array_split(score, parts), np.array_split(is_obstacle, parts), strict=True):
        roc.add(scores.astype(np.float32), truths.astype(np.float64), (~truths).astype(np.float64))
    return roc


def drawn(seed: int, scale: float, shift: float) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    is_obstacle = rng.random(20_000) < 0.3
    return (np.abs(rng.standard_normal(20_000)) + is_obstacle * rng.random(20_000)) * scale + shift, is_obstacle


@pytest.mark.parametrize(("scale", "shift"), [(1.0, 0.0), (1e-6, 0.0), (1e6, 0.0), (1.0, -1.0), (-0.3, 0.0)])
@pytest.mark.parametrize("seed", range(3))
def test_area_is_scikit_learns(seed: int, scale: float, shift: float) -> None:
    score, is_obstacle = drawn(seed, scale, shift)
    area = filled(score, is_obstacle).area()
    assert area == pytest.approx(roc_auc_score(is_obstacle, score), abs=1e-3)


@pytest.mark.parametrize("seed", range(3))
def test_recall_is_scikit_learns(seed: int) -> None:
    score, is_obstacle = drawn(seed, 1.0, 0.0)
    alarms, found, _ = roc_curve(is_obstacle, score)
    recall = filled(score, is_obstacle).recall(0.05)
    assert recall == pytest.approx(np.interp(0.05, alarms, found), abs=2e-3)


def test_ties_count_half() -> None:
    roc = filled(np.ones(10), np.arange(10) < 3)
    assert roc.area() == 0.5
    assert roc.recall(0.05) == pytest.approx(0.05)
    assert filled(np.array([0.0, -0.0]), np.array([True, False]), parts=1).area() == 0.5


def test_perfect_and_reversed_scores() -> None:
    is_obstacle = np.arange(100) >= 80
    assert filled(np.arange(100), is_obstacle).area() == 1.0
    assert filled(np.arange(100), is_obstacle).recall(0.05) == 1.0
    assert filled(-np.arange(100), is_obstacle).area() == 0.0
    assert filled(-np.arange(100), is_obstacle).recall(0.05) == 0.0


@hypothesis.settings(max_examples=50, deadline=None)
@hypothesis.given(st.lists(st.tuples(st.integers(-20, 20), st.booleans()), min_size=1, max_size=40))
def test_area_of_few_scores_is_exact(pairs: list[tuple[int, bool]]) -> None:
    score, is_obstacle = (np.array(column) for column in zip(*pairs, strict=True))
    area = filled(score, is_obstacle, parts=1).area()
    if is_obstacle.all() or not is_obstacle.any():
        assert area is None
    else:
        assert area == pytest.approx(roc_auc_score(is_obstacle, score))


def test_without_both_kinds_nothing_is_defined() -> None:
    assert Roc().area() is None
    assert Roc().recall(0.05) is None
    assert filled(np.arange(9), np.zeros(9, bool)).area() is None


def test_more_scores_than_are_kept_at_a_time_count_alike() -> None:
    rng = np.random.default_rng(0)
    is_obstacle = rng.random(100_000) < 0.3
    score = rng.integers(0, 50, 100_000) + 5.0 * is_obstacle
    areas = [filled(score, is_obstacle, parts).area() for parts in (1, 3, 400)]
    assert areas == [pytest.approx(roc_auc_score(is_obstacle, score))] * 3


def test_what_scores_lowest_counts_as_an_even_lower_score_does() -> None:
    rng = np.random.default_rng(5)
    score, obstacle, ground = (rng.random(500) for _ in range(3))
    explicit, lowest = Roc(), Roc()
    explicit.add(np.append(score, 1e-6).astype(np.float32), np.append(obstacle, 40.0), np.append(ground, 90.0))
    lowest.add(score.astype(np.float32), obstacle, ground)
    lowest.add_lowest(40.0, 90.0)
    assert lowest.area() == pytest.approx(explicit.area())
    for ratio in (0.0, 0.05, 0.5, 0.9, 1.0):
        assert lowest.recall(ratio) == pytest.approx(explicit.recall(ratio))


def test_pixels_that_score_lowest_alone_are_a_coin_toss() -> None:
    roc = Roc()
    roc.add_lowest(3.0, 0.0)
    assert roc.area() is None
    roc.add_lowest(0.0, 5.0)
    assert roc.area() == pytest.approx(0.5)
