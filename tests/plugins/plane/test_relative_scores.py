"""With ``threshold_ratio`` scores are relative to the flow's length: ratios, finite wherever the flow is not."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from graphnav_plane.affine import Affine
from graphnav_plane.detector import relative
from graphnav_plane.homography import Homography
from graphnav_plane.residual import Residual
from graphnav_plane.row_line import RowLine

from graphnav import Flow, Plane, Stamp
from graphnav.core.stage import params_of, unit_of

if TYPE_CHECKING:
    from tests.plugins.plane.conftest import Scene, Scenes

FLOW_DETECTORS = [Affine, Homography, RowLine]
pytestmark = pytest.mark.filterwarnings("error")


def seen(detector: Affine | Homography | RowLine | Residual, scene: Scene) -> Plane:
    detector.reset(0)
    if isinstance(detector, Residual):
        return detector.step(scene.flow, scene.planar, Stamp(0))
    return detector.step(scene.flow, Stamp(0))


@pytest.mark.parametrize("kind", [*FLOW_DETECTORS, Residual])
def test_scores_are_divided_by_the_length_plus_a_pixel(
    scenes: Scenes, kind: type[Affine | Homography | RowLine | Residual]
) -> None:
    scene = scenes.scene(0.25)
    length_px = np.linalg.norm(scene.flow.uv_px, axis=-1)
    pixels, ratios = (seen(kind(threshold_ratio=ratio), scene) for ratio in (None, 0.1))
    assert ratios.score == pytest.approx(pixels.score / (length_px + 1), rel=1e-5)
    assert ratios.score.max() < 1


@pytest.mark.parametrize("kind", FLOW_DETECTORS)
def test_off_by_default_and_a_ratio_by_its_name(kind: type[Affine | Homography | RowLine]) -> None:
    param = params_of(kind)["threshold_ratio"]
    assert param.default is None
    assert unit_of(param.name).words == "a ratio"
    assert unit_of("threshold_px").words == "pixels"


def test_the_threshold_is_the_ratio_and_not_the_pixels(scenes: Scenes) -> None:
    scene = scenes.scene(0.25)
    fixed = seen(Homography(rule="fixed", threshold_px=0.08, threshold_ratio=0.05, edge_ratio=0.0), scene)
    assert fixed.threshold == 0.05
    assert np.array_equal(fixed.obstacle != 0, fixed.score > 0.05)
    assert (fixed.obstacle != 0)[scene.obstacle].mean() > 0.8
    assert (fixed.obstacle != 0)[~scene.obstacle].mean() < 0.02
    assert seen(Homography(threshold_px=0.08, threshold_ratio=0.4), scene).threshold == 0.4


@pytest.mark.parametrize("kind", FLOW_DETECTORS)
def test_a_longer_flow_of_the_same_shape_scores_alike(
    scenes: Scenes, kind: type[Affine | Homography | RowLine]
) -> None:
    scene = scenes.scene(0.25, drive_px=8.0, noise_px=0.0)
    longer = replace(scene, flow=replace(scene.flow, uv_px=scene.flow.uv_px * np.float32(2)))
    pixels, longer_pixels = (seen(kind(threshold_px=0.1), one).score.max() for one in (scene, longer))
    ratio, longer_ratio = (
        seen(kind(threshold_px=0.1, threshold_ratio=0.0), one).score.max() for one in (scene, longer)
    )
    assert longer_pixels > 1.6 * pixels
    assert longer_ratio < 1.2 * ratio


@pytest.mark.parametrize("kind", FLOW_DETECTORS)
def test_no_motion_scores_zero(scenes: Scenes, kind: type[Affine | Homography | RowLine]) -> None:
    still = scenes.flow(np.zeros((30, 40, 2)))
    scene = replace(scenes.scene(), flow=still)
    plane = seen(kind(threshold_ratio=0.1), scene)
    assert plane.score.max() < 1e-6
    assert not plane.obstacle.any()


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 3e38])
@pytest.mark.parametrize("kind", FLOW_DETECTORS)
def test_vectors_that_are_not_valid_score_zero_whatever_they_hold(
    scenes: Scenes, kind: type[Affine | Homography | RowLine], bad: float
) -> None:
    scene = scenes.scene(0.25)
    hole = np.zeros((30, 40), np.bool_)
    hole[5:9, 10:20] = True
    flow = scene.flow
    holed = Flow(
        uv_px=np.where(hole[..., None], np.float32(bad), flow.uv_px),
        valid=(~hole).astype(np.uint8),
        interval_us=flow.interval_us,
        step_px=flow.step_px,
    )
    score = relative(np.ones((30, 40), np.float32), ~hole, holed)
    assert np.isfinite(score).all()
    assert not score[hole].any()
    assert (score[~hole] > 0).all()
    empty = replace(holed, uv_px=np.where(hole[..., None], np.float32(0), flow.uv_px))
    plane = seen(kind(threshold_ratio=0.1), replace(scene, flow=empty))
    assert not plane.score[hole].any()
    assert not plane.valid[hole].any()


@pytest.mark.parametrize("kind", FLOW_DETECTORS)
def test_without_a_valid_vector_nothing_is_judged(scenes: Scenes, kind: type[Affine | Homography | RowLine]) -> None:
    scene = scenes.scene()
    plane = seen(
        kind(threshold_ratio=0.1), replace(scene, flow=replace(scene.flow, valid=np.zeros_like(scene.flow.valid)))
    )
    assert not plane.valid.any()
    assert not plane.score.any()
    assert plane.obstacle_ratio == 0
