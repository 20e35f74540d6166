"""The baselines score what theory says."""

from __future__ import annotations

from typing import TYPE_CHECKING

import graphnav_score.plane as score
import numpy as np
import pytest
from graphnav_plane.affine import Affine
from graphnav_plane.all_ground import AllGround
from graphnav_plane.appearance import Appearance
from graphnav_plane.homography import Homography
from graphnav_plane.ica import Ica
from graphnav_plane.learned import Learned
from graphnav_plane.one_gain import OneGain
from graphnav_plane.residual import Residual
from graphnav_plane.row_line import RowLine
from graphnav_plane.row_median import RowMedian
from graphnav_plane.row_prior import RowPrior
from graphnav_plane.truth import Truth as Oracle

from graphnav import Flow, Plane, Truth
from graphnav.arrays import Bools

if TYPE_CHECKING:
    from tests.plugins.plane.conftest import Scenes


def scored(plane: Plane, obstacle: Bools) -> dict[str, float]:
    stage = score.Plane()
    stage.reset(0)
    shape = obstacle.shape
    flow_px = np.ones((*shape, 2), np.float32)
    depth_m = np.ones(shape, np.float32)
    stage.step(
        plane,
        Truth(obstacle=obstacle.astype(np.uint8), depth_m=depth_m, flow_px=flow_px, interval_us=100_000, step_px=4),
    )
    return dict(stage.summary())


def random_obstacle(seed: int) -> Bools:
    rng = np.random.default_rng(seed)
    return np.asarray(rng.random((30, 40)) < np.linspace(0.6, 0.0, 30)[:, None])


@pytest.mark.parametrize("seed", range(3))
def test_all_ground_scores_one_half_exactly(scenes: Scenes, seed: int) -> None:
    metrics = scored(AllGround().step(scenes.scene(0.25, seed=seed).flow), random_obstacle(seed))
    assert metrics["auroc"] == 0.5
    assert metrics["balanced_accuracy_ratio"] == 0.5
    assert metrics["iou_ratio"] == 0.0
    assert metrics["false_obstacle_ratio"] == 0.0


@pytest.mark.parametrize("seed", range(3))
def test_the_row_prior_scores_what_the_rows_alone_tell(scenes: Scenes, seed: int) -> None:
    obstacle = random_obstacle(seed)
    metrics = scored(RowPrior().step(scenes.scene(0.25, seed=seed).flow), obstacle)
    rows = np.broadcast_to(np.arange(30)[:, None], obstacle.shape)
    higher, level = rows[obstacle][:, None] < rows[~obstacle], rows[obstacle][:, None] == rows[~obstacle]
    area = higher.mean() + level.mean() / 2
    assert metrics["auroc"] == pytest.approx(area, abs=0.005)  # the score's bins are 0.2 % wide


def test_the_row_prior_does_not_look_at_the_flow(scenes: Scenes) -> None:
    one, other = (RowPrior().step(scenes.scene(share, turn_rad=turn).flow) for share, turn in ((0.0, 0.0), (0.4, 0.1)))
    assert np.array_equal(one.score, other.score)
    assert np.array_equal(one.obstacle, other.obstacle)
    assert (np.diff(one.score, axis=0) < 0).all()
    assert (np.diff(one.score, axis=1) == 0).all()


@pytest.mark.parametrize(("ratio", "rows"), [(0.0, 0), (0.1, 3), (0.5, 15), (1.0, 30)])
def test_the_row_prior_calls_the_upper_rows_obstacle(scenes: Scenes, ratio: float, rows: int) -> None:
    plane = RowPrior(horizon_ratio=ratio).step(scenes.scene().flow)
    assert plane.obstacle[:rows].all()
    assert not plane.obstacle[rows:].any()
    assert plane.obstacle_ratio == pytest.approx(rows / 30)
    assert np.array_equal(plane.obstacle > 0, plane.score > plane.threshold)


@pytest.mark.parametrize("baseline", [AllGround(), RowPrior(horizon_ratio=1.0)])
def test_baselines_judge_the_cells_that_the_detectors_judge(scenes: Scenes, baseline: AllGround | RowPrior) -> None:
    valid = np.ones((119, 158), np.uint8)
    valid[:, :17] = 0
    flow = Flow(uv_px=np.zeros((119, 158, 2), np.float32), valid=valid, interval_us=100_000)
    stage = Affine()
    stage.reset(0)
    detected, plane = stage.step(flow, scenes.stamp()), baseline.step(flow)
    assert np.array_equal(plane.valid, detected.valid)
    assert plane.step_px == detected.step_px
    assert not plane.obstacle[plane.valid == 0].any()


def test_tables_can_tell_methods_from_baselines_and_oracles() -> None:
    assert {kind.role for kind in (Ica, Affine, Homography, Learned)} == {"method"}
    baselines = (Residual, OneGain, AllGround, RowPrior, RowMedian, RowLine, Appearance)
    assert {kind.role for kind in baselines} == {"baseline"}
    assert Oracle.role == "oracle"
