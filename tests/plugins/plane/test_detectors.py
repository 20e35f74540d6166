"""Every detector sees obstacles, sees none on an empty floor, and keeps its head where there is little to see."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from graphnav_plane.affine import Affine
from graphnav_plane.detector import Detector
from graphnav_plane.guided_homography import GuidedHomography
from graphnav_plane.homography import Homography
from graphnav_plane.ica import Ica
from graphnav_plane.one_gain import OneGain
from graphnav_plane.residual import Residual
from graphnav_plane.row_line import RowLine

from graphnav import Flow, Plane, Stamp

if TYPE_CHECKING:
    from tests.plugins.plane.conftest import Scene, Scenes

DETECTORS = [Ica, Affine, Homography, GuidedHomography, Residual, OneGain, RowLine]
COMPARING = [Ica, GuidedHomography, Residual, OneGain]
MOTIONS = [(3.0, 0.0), (3.0, 0.05), (1.0, -0.1), (0.0, 0.1), (0.0, 0.0)]

pytestmark = pytest.mark.filterwarnings("error")


def seen(detector: Detector, scene: Scene) -> Plane:
    detector.reset(0)
    if isinstance(detector, Affine | Homography | RowLine):
        return detector.step(scene.flow, Stamp(0))
    if isinstance(detector, Ica):
        return detector.step(scene.flow, scene.planar, Stamp(0)).plane
    assert isinstance(detector, GuidedHomography | Residual | OneGain)
    return detector.step(scene.flow, scene.planar, Stamp(0))


@pytest.mark.parametrize("kind", DETECTORS)
@pytest.mark.parametrize("share", [0.1, 0.25, 0.35])
@pytest.mark.parametrize("turn_rad", [0.0, 0.05])
def test_an_obstacle_is_told_from_the_floor(
    scenes: Scenes, kind: type[Detector], share: float, turn_rad: float
) -> None:
    scene = scenes.scene(share, turn_rad=turn_rad)
    plane = seen(kind(), scene)
    found = plane.obstacle > 0
    assert (found & scene.obstacle).sum() > 0.8 * scene.obstacle.sum()
    assert (found & ~scene.obstacle).sum() < 0.02 * (~scene.obstacle).sum()


@pytest.mark.parametrize("kind", DETECTORS)
@pytest.mark.parametrize(("drive_px", "turn_rad"), MOTIONS)
def test_an_empty_floor_holds_at_most_one_percent_obstacle(
    scenes: Scenes, kind: type[Detector], drive_px: float, turn_rad: float
) -> None:
    shares = [
        # what flow.lucas_kanade errs by at an image noise of 4 gray levels
        seen(kind(), scenes.scene(0.0, drive_px, turn_rad, noise_px=0.03, seed=seed)).obstacle_ratio
        for seed in range(5)
    ]
    assert np.mean(shares) <= 0.01


@pytest.mark.parametrize("kind", DETECTORS)
def test_an_obstacle_of_three_percent_is_not_guarded_away(scenes: Scenes, kind: type[Detector]) -> None:
    scene = scenes.scene(0.0)
    obstacle = np.zeros((30, 40), np.bool_)
    obstacle[12:18, 20:26] = True
    raised = np.where(obstacle[..., None], 1.25 * scene.planar.planar_uv_px, scene.flow.uv_px)
    plane = seen(kind(), replace(scene, flow=replace(scene.flow, uv_px=raised)))
    assert plane.obstacle[obstacle].mean() > 0.8
    assert plane.obstacle[~obstacle].mean() < 0.01


@pytest.mark.parametrize("kind", DETECTORS)
def test_cells_without_a_valid_vector_are_not_judged_and_change_nothing(scenes: Scenes, kind: type[Detector]) -> None:
    scene = scenes.scene(0.25)
    valid = scene.flow.valid.copy()
    valid[-4:] = 0
    rubbish = scene.flow.uv_px.copy()
    rubbish[-4:] = 1e6
    one = seen(kind(), replace(scene, flow=replace(scene.flow, valid=valid)))
    other = seen(kind(), replace(scene, flow=replace(scene.flow, valid=valid, uv_px=rubbish)))
    assert np.array_equal(one.obstacle, other.obstacle)
    assert np.array_equal(one.score, other.score)
    assert not one.valid[-4:].any()
    assert not one.obstacle[-4:].any()


@pytest.mark.parametrize("kind", DETECTORS)
@pytest.mark.parametrize("vectors", [0, 5])
def test_fewer_than_six_vectors_are_not_judged(scenes: Scenes, kind: type[Detector], vectors: int) -> None:
    scene = scenes.scene(0.25)
    valid = np.zeros((30, 40), np.uint8)
    valid.flat[:vectors] = 1
    plane = seen(kind(), replace(scene, flow=replace(scene.flow, valid=valid)))
    assert not plane.valid.any()
    assert not plane.obstacle.any()
    assert plane.obstacle_ratio == 0.0


@pytest.mark.parametrize("kind", DETECTORS)
def test_six_vectors_on_a_line_are_judged_without_a_fault(scenes: Scenes, kind: type[Detector]) -> None:
    scene = scenes.scene(0.25)
    valid = np.zeros((30, 40), np.uint8)
    valid[3, :6] = 1
    plane = seen(kind(), replace(scene, flow=replace(scene.flow, valid=valid)))
    assert plane.valid.sum() == 6
    assert plane.not_finite() is None


@pytest.mark.parametrize("kind", DETECTORS)
def test_a_robot_at_rest_sees_ground(scenes: Scenes, kind: type[Detector]) -> None:
    plane = seen(kind(), scenes.scene(0.0, drive_px=0.0, noise_px=0.0))
    assert plane.valid.all()
    assert not plane.obstacle.any()
    assert plane.not_finite() is None


@pytest.mark.parametrize("kind", DETECTORS)
def test_a_huge_flow_stays_finite(scenes: Scenes, kind: type[Detector]) -> None:
    scene = scenes.scene(0.25, drive_px=1e6, noise_px=1e3)
    assert seen(kind(), scene).not_finite() is None


@pytest.mark.parametrize("kind", DETECTORS)
@pytest.mark.parametrize("size", [(2, 2), (1, 7), (3, 2)])
def test_tiny_pictures_stay_finite(scenes: Scenes, kind: type[Detector], size: tuple[int, int]) -> None:
    uv_px = scenes.floor(3.0, 0.05, *size)
    scene = replace(scenes.scene(), flow=scenes.flow(1.01 * uv_px), planar=scenes.planar(uv_px))
    plane = seen(kind(), scene)
    assert plane.obstacle.shape == size
    assert plane.not_finite() is None


@pytest.mark.parametrize("kind", DETECTORS)
def test_dense_flow_is_averaged_over_cells_cut_ones_included(scenes: Scenes, kind: type[Detector]) -> None:
    scene = scenes.scene(0.25, noise_px=0.0)
    dense = Flow(
        uv_px=scene.flow.uv_px.repeat(4, 0).repeat(4, 1)[:-1, :-1],
        valid=np.ones((119, 159), np.uint8),
        interval_us=100_000,
    )
    plane = seen(kind(), replace(scene, flow=dense))
    assert plane.step_px == 4
    assert plane.obstacle.shape == (30, 40)
    assert (plane.obstacle[:, 30:] > 0).mean() > 0.8


@pytest.mark.parametrize("kind", COMPARING)
def test_another_picture_size_is_refused(scenes: Scenes, kind: type[Detector]) -> None:
    scene = replace(scenes.scene(), flow=scenes.flow(scenes.floor(3.0, 0.0, 15, 20)))
    with pytest.raises(ValueError, match="planar flow is 40x30 cells of 4 px, but the flow is 20x15 of them"):
        seen(kind(), scene)


@pytest.mark.parametrize("kind", COMPARING)
def test_cells_that_were_not_taught_are_not_judged(scenes: Scenes, kind: type[Detector]) -> None:
    scene = scenes.scene(0.25)
    taught = scene.planar.planar_valid.copy()
    taught[:3] = 0
    plane = seen(kind(), replace(scene, planar=replace(scene.planar, planar_valid=taught)))
    assert np.array_equal(plane.valid, taught)


@pytest.mark.parametrize("kind", DETECTORS)
def test_the_same_seed_gives_the_same_plane(scenes: Scenes, kind: type[Detector]) -> None:
    scene = scenes.scene(0.25)
    one, other = seen(kind(), scene), seen(kind(), scene)
    assert np.array_equal(one.score, other.score)


@pytest.mark.parametrize("kind", DETECTORS)
def test_the_share_and_the_threshold_say_what_the_map_is(scenes: Scenes, kind: type[Detector]) -> None:
    plane = seen(kind(), scenes.scene(0.25))
    assert np.array_equal(plane.obstacle > 0, plane.score > plane.threshold)
    assert plane.obstacle_ratio == pytest.approx(plane.obstacle[plane.valid > 0].mean())
    assert plane.converged


def test_the_median_removes_specks_and_keeps_walls(scenes: Scenes) -> None:
    scene = scenes.scene(0.25)
    uv_px = scene.flow.uv_px.copy()
    uv_px[10, 5] += 2.0
    specked = replace(scene, flow=replace(scene.flow, uv_px=uv_px))
    assert seen(Residual(), specked).obstacle[10, 5]
    cleaned = seen(Residual(median_cells=3), specked)
    assert not cleaned.obstacle[10, 5]
    assert cleaned.obstacle[:10, 32:].all()
