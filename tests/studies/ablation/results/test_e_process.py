"""Evidence that may be looked at after every world: few false alarms, and real differences found."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from graphnav.studies.ablation.results.statistics import BETS, e_process, holm

Draw = Callable[[np.random.Generator, tuple[int, int]], np.ndarray]

STUDIES, WORLDS = 1000, 200


def ties_and_rare_differences(rng: np.random.Generator, shape: tuple[int, int]) -> np.ndarray:
    return rng.choice([-1.0, 0.0, 1.0], shape, p=[0.05, 0.9, 0.05])


def unlike_in_every_world(rng: np.random.Generator, shape: tuple[int, int]) -> np.ndarray:
    return rng.choice([-1.0, 1.0], shape)


def skewed(rng: np.random.Generator, shape: tuple[int, int]) -> np.ndarray:
    """Of mean 0: rarely -0.9, mostly a little above 0."""
    return np.where(rng.random(shape) < 0.1, -0.9, 0.1)


def of_two_skewed_metrics(rng: np.random.Generator, shape: tuple[int, int]) -> np.ndarray:
    return rng.beta(5, 1, shape) - rng.beta(5, 1, shape)


@pytest.mark.parametrize("draw", [ties_and_rare_differences, unlike_in_every_world, skewed, of_two_skewed_metrics])
def test_without_a_difference_it_raises_a_false_alarm_at_any_time_in_5_percent_at_most(draw: Draw) -> None:
    alarms = 0
    for seed in range(4):
        differences = draw(np.random.default_rng(seed), (STUDIES // 4, WORLDS))
        alarms += int(np.count_nonzero(e_process(differences).max(axis=-1) >= 20))
    assert alarms <= 0.05 * STUDIES
    assert alarms > 0, "looking at all times costs something, or the test sees nothing"


def test_with_several_variants_any_false_alarm_is_as_rare() -> None:
    alarms = 0
    for seed in range(100):
        rng = np.random.default_rng(seed)
        base = rng.beta(5, 1, (5, WORLDS))
        differences = rng.beta(5, 1, (5, 4, WORLDS)) - base[:, None]  # the variants share the base's runs
        best = e_process(differences).max(axis=-1)
        alarms += sum(any(found.is_significant for found in holm(list(1 / row), 4)) for row in best)
    assert alarms <= 0.05 * 500


def test_it_is_a_fair_game() -> None:
    """Over all 2^8 courses of a fair coin the mean wealth is 1, after every world."""
    courses = np.array([[1.0 if course >> world & 1 else -1.0 for world in range(8)] for course in range(256)])
    assert e_process(courses).mean(axis=0) == pytest.approx(np.ones(8))


def test_where_one_always_wins_the_evidence_is_the_mean_over_all_bets() -> None:
    expected = [np.mean([(1 + bet) ** n + (1 - bet) ** n for bet in BETS]) / 2 for n in range(1, 11)]
    found = e_process(np.ones(10))
    assert found == pytest.approx(expected)
    assert e_process(-np.ones(10)) == pytest.approx(expected)
    assert next(n for n in range(10) if found[n] >= 20) == 7, "eight worlds decide what fifty would, too"


def test_a_real_difference_is_found() -> None:
    differences = np.random.default_rng(0).choice([-1.0, 0.0, 1.0], (400, 100), p=[0.05, 0.6, 0.35])
    assert np.mean(e_process(differences).max(axis=-1) >= 20) > 0.85


def test_many_worlds_do_not_overflow() -> None:
    assert np.isfinite(e_process(np.ones(100_000))).all()
