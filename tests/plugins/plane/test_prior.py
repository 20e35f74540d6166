"""Rows and a detector's scores add up as log-odds; what is not judged, empty or of another kind is treated as told."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from graphnav_plane.all_ground import AllGround
from graphnav_plane.homography import Homography
from graphnav_plane.prior import Prior
from graphnav_plane.row_prior import RowPrior

from graphnav import Plane, Stamp
from graphnav.arrays import Doubles
from graphnav.testing import check_stage

if TYPE_CHECKING:
    from tests.plugins.plane.conftest import Scenes

pytestmark = pytest.mark.filterwarnings("error")


def plane(score: Doubles, threshold: float = 0.5) -> Plane:
    """Return a plane of these scores, all judged."""
    obstacle = (score > threshold).astype(np.uint8)
    valid = np.ones(score.shape, np.uint8)
    return Plane(obstacle, score.astype(np.float32), valid, 4, float(obstacle.mean()) if score.size else 0.0, threshold)


def noise(rows: int = 30, cols: int = 40, seed: int = 0) -> Doubles:
    return np.random.default_rng(seed).uniform(0.0, 2.0, (rows, cols))


def log_odds(found: Plane) -> Doubles:
    probability = found.score.astype(np.float64)
    return np.asarray(np.log(probability / (1 - probability)))


def test_log_odds_of_row_and_detector_are_added() -> None:
    found = Prior(horizon_ratio=0.3, width_ratio=0.2, detector_weight=0.5).step(plane(noise()))
    rows = (0.3 - (np.arange(30)[:, None] + 0.5) / 30) / 0.2
    detector = np.log(np.clip(noise().astype(np.float32) / 0.5, 1 / 20, 20))
    assert log_odds(found) == pytest.approx(rows + 0.5 * detector, abs=1e-4)
    assert np.array_equal(found.obstacle != 0, rows + 0.5 * detector > 0)
    assert found.threshold == 0.5
    assert found.obstacle_ratio == pytest.approx(found.obstacle.mean())


def test_the_row_alone_orders_cells_as_the_row_prior_does(scenes: Scenes) -> None:
    flow = scenes.scene(0.25).flow
    rows = RowPrior(horizon_ratio=0.25).step(flow)
    alone = Prior(detector_weight=0.0, horizon_ratio=0.25).step(plane(noise()))
    assert np.array_equal(np.argsort(alone.score[:, 0]), np.argsort(rows.score[:, 0]))
    assert np.ptp(alone.score, axis=1).max() == 0
    assert np.array_equal(alone.obstacle, rows.obstacle)


def test_a_detector_without_an_opinion_leaves_the_rows_as_they_are(scenes: Scenes) -> None:
    ground = AllGround().step(scenes.scene().flow)
    assert np.array_equal(Prior().step(ground).score, Prior(detector_weight=0.0).step(ground).score)


def test_a_detector_moves_the_border_between_obstacle_and_ground(scenes: Scenes) -> None:
    scene = scenes.scene(0.25)
    detector = Homography()
    detector.reset(0)
    found = Prior(detector_weight=2.0).step(detector.step(scene.flow, Stamp(0)))
    top = found.obstacle[2] != 0
    assert found.obstacle[:, -5:].mean() > found.obstacle[:, :25].mean() + 0.2
    assert top[-8:].all()


@pytest.mark.parametrize("threshold", [0.0, 1e-9, 0.5, 1e6])
def test_scores_and_thresholds_of_zero_have_finite_odds(threshold: float) -> None:
    score = np.array([[0.0, threshold, 1e6]])
    found = Prior(horizon_ratio=0.5, detector_weight=1.0, max_score_ratio=10.0).step(plane(score, threshold))
    below, even, above = log_odds(found)[0]
    assert even == pytest.approx(0.0, abs=1e-5)
    assert below == pytest.approx(-np.log(10) if threshold else 0.0, abs=1e-5)
    assert above == pytest.approx(np.log(10) if threshold < 1e6 else 0.0, abs=1e-5)


@pytest.mark.parametrize("weight", [0.0, 100.0])
def test_even_cells_far_below_the_horizon_keep_a_probability(weight: float) -> None:
    found = Prior(horizon_ratio=-10.0, width_ratio=1e-3, detector_weight=weight).step(plane(noise()))
    assert ((found.score > 0) & (found.score < 1)).all()
    assert not found.obstacle.any()


def test_log_odds_are_added_as_they_are() -> None:
    score = noise() - 1.0
    found = Prior(horizon_ratio=0.5, detector_weight=1.0, scores="log_odds").step(plane(score, -0.2))
    rows = (0.5 - (np.arange(30)[:, None] + 0.5) / 30) / 0.1
    assert log_odds(found) == pytest.approx(rows + score + 0.2, abs=1e-3)


def test_negative_scores_are_no_ratios() -> None:
    with pytest.raises(ValueError, match=r"a score is -0\.25, .*set 'scores: log_odds'"):
        Prior().step(plane(noise() - 0.25 - noise().min()))


def test_what_was_not_judged_stays_so_unless_the_rows_may_fill_it() -> None:
    seen = plane(noise())
    seen = replace(seen, valid=(noise(seed=1) > 1).astype(np.uint8), score=np.where(noise(seed=1) > 1, seen.score, -9))
    unjudged = seen.valid == 0
    kept, filled = Prior().step(seen), Prior(fills_unjudged=True).step(seen)
    assert np.array_equal(kept.valid, seen.valid)
    assert not kept.score[unjudged].any()
    assert not kept.obstacle[unjudged].any()
    assert filled.valid.all()
    assert np.array_equal(filled.score[unjudged], Prior(detector_weight=0.0).step(plane(noise())).score[unjudged])
    assert np.array_equal(filled.score[~unjudged], kept.score[~unjudged])
    assert filled.obstacle_ratio == pytest.approx(filled.obstacle.mean())


@pytest.mark.parametrize("fills", [False, True])
def test_a_plane_in_which_nothing_was_judged(*, fills: bool) -> None:
    nothing = np.zeros((7, 5), np.uint8)
    found = Prior(fills_unjudged=fills).step(Plane(nothing, nothing.astype(np.float32), nothing, 4, 0.0))
    assert found.valid.all() == fills
    assert (found.obstacle_ratio > 0) == fills


@pytest.mark.parametrize(("rows", "cols"), [(1, 1), (1, 40), (31, 1), (17, 23)])
def test_any_size_of_plane(rows: int, cols: int) -> None:
    check_stage(Prior, {"plane": plane(noise(rows, cols))}, {"plane": plane(noise(cols, rows, 1))})
    found = Prior().step(plane(noise(rows, cols)))
    assert found.score.shape == (rows, cols)
