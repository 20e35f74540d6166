"""Which component sees the obstacle: its metrics against scikit-learn."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from graphnav_score.components import Components as ComponentsScore
from sklearn.metrics import roc_auc_score

from graphnav import Components, Truth
from graphnav.arrays import Bools, Doubles

MakeTruth = Callable[..., Truth]


def components(alpha: Doubles, beta: Doubles, valid: Bools, taken: int) -> Components:
    fields = [np.stack([length, np.zeros_like(length)], axis=-1).astype(np.float32) for length in (alpha, beta)]
    return Components(
        alpha=fields[0],
        beta=fields[1],
        mixing=np.eye(2),
        variances=np.array([alpha[valid].var(), beta[valid].var()]),
        taken=taken,
        valid=valid.astype(np.uint8),
        step_px=4,
    )


def scored() -> ComponentsScore:
    stage = ComponentsScore()
    stage.reset(seed=0)
    return stage


def test_each_area_is_that_of_its_deviation_from_the_median(make_truth: MakeTruth) -> None:
    rng = np.random.default_rng(0)
    stage = scored()
    deviations: list[list[Doubles]] = [[], []]
    truths = []
    for taken in (0, 0, 1):
        true = np.zeros((24, 32), bool)
        true[4:12, 4:20] = True
        alpha = 5 + 0.1 * rng.random((6, 8))
        beta = rng.random((6, 8)) + true[::4, ::4]
        valid = rng.random((6, 8)) < 0.8
        stage.step(components(alpha, beta, valid, taken), make_truth(true))
        seen = np.kron(valid, np.ones((4, 4))).astype(bool)
        for kept, length in zip(deviations, (alpha, beta), strict=True):
            kept.append(np.kron(np.abs(length - np.median(length[valid])), np.ones((4, 4)))[seen])
        truths.append(true[seen])
    metrics = stage.summary()
    is_obstacle = np.concatenate(truths)
    for name, kept in zip(("alpha", "beta"), deviations, strict=True):
        expected = roc_auc_score(is_obstacle, np.concatenate(kept))
        assert metrics[f"{name}_auroc"] == pytest.approx(expected, abs=5e-3)
    assert metrics["frames"] == 3
    assert metrics["alpha_taken_ratio"] == pytest.approx(2 / 3)
    assert metrics["median_variance_ratio"] < 0.1


def test_a_frame_of_mostly_obstacle_counts_for_the_components_but_not_for_the_areas(make_truth: MakeTruth) -> None:
    stage = scored()
    length = np.arange(48.0).reshape(6, 8)
    stage.step(components(length, 2 * length, np.ones((6, 8), bool), 1), make_truth(np.ones((24, 32), bool)))
    assert stage.summary() == {"frames": 0.0, "median_variance_ratio": 0.25, "alpha_taken_ratio": 0.0}
