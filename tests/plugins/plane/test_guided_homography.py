"""The floor is found under rotation of the camera, and where another plane is the larger one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from graphnav_plane.guided_homography import GuidedHomography
from graphnav_plane.homography import Homography
from graphnav_plane.residual import Residual

from graphnav import Stamp
from graphnav.arrays import Bools, Floats

if TYPE_CHECKING:
    from tests.plugins.plane.conftest import Scene, Scenes

FOCAL_PX = 114.0


def raised_top(scenes: Scenes, share: float, rise: float, pitch_px: float, seed: int = 0) -> tuple[Scene, Bools, Scene]:
    """Return a frame in which a flat top, ``rise`` nearer than the floor, covers this share at the right.

    With it come the cells of the top, and the same frame seen by a camera that pitches by ``pitch_px``.
    """
    scene = scenes.scene(0.0, turn_rad=0.02, noise_px=0.04, seed=seed)
    top = np.broadcast_to(np.arange(40) >= 40 - round(40 * share), (30, 40))
    uv_px = scene.flow.uv_px + rise * top[..., None] * scene.planar.planar_uv_px
    y, x = np.mgrid[:30, :40] * 4.0 - np.array([58.0, 78.0])[:, None, None]
    pitch = pitch_px * np.stack([x * y / FOCAL_PX**2, 1 + (y / FOCAL_PX) ** 2], axis=-1)
    still, pitched = (type(scene)(scenes.flow(flow), scene.planar, top) for flow in (uv_px, uv_px + pitch))
    return still, top, pitched


def scored(stage: GuidedHomography | Homography | Residual, scene: Scene) -> Floats:
    stage.reset(0)
    if isinstance(stage, Homography):
        return stage.step(scene.flow, Stamp(0)).score
    return stage.step(scene.flow, scene.planar, Stamp(0)).score


@pytest.mark.parametrize("share", [0.6, 0.7])
@pytest.mark.parametrize("rise", [0.35, 0.5])
def test_the_floor_is_ground_where_another_plane_is_larger(scenes: Scenes, share: float, rise: float) -> None:
    scene, top, _ = raised_top(scenes, share, rise, 0.0)
    free, guided = scored(Homography(), scene), scored(GuidedHomography(), scene)
    assert free[:, 0].mean() > free[top].mean()  # takes the top for the ground
    # the floor moves by 3 px; half of the parallax is left for what a fit to one side errs by on the other
    assert guided[top].mean() > 0.5 * 3 * rise
    assert guided[~top].mean() < 0.15


@pytest.mark.parametrize("pitch_px", [-1.5, 1.5])
def test_a_rotation_of_the_camera_is_no_obstacle(scenes: Scenes, pitch_px: float) -> None:
    _, top, scene = raised_top(scenes, 0.3, 0.35, pitch_px)
    assert scored(Residual(), scene)[~top].mean() > 1.0
    guided = scored(GuidedHomography(), scene)
    assert guided[~top].mean() < 0.15
    assert guided[top].mean() > 0.5 * 3 * 0.35


def test_without_the_free_homography_a_top_of_the_rotations_size_is_the_ground(scenes: Scenes) -> None:
    _, top, scene = raised_top(scenes, 0.3, 0.5, -1.5)
    assert scored(GuidedHomography(min_agreement_ratio=0.0), scene)[~top].mean() > 1.0
    assert scored(GuidedHomography(), scene)[~top].mean() < 0.15


@pytest.mark.parametrize("gain", [0.75, 1.25])
def test_a_wrong_scale_of_odometry_is_corrected(scenes: Scenes, gain: float) -> None:
    scene = scenes.scene(0.25, turn_rad=0.03, gain=gain)
    score = scored(GuidedHomography(), scene)
    assert score[~scene.obstacle].mean() < 0.1
    assert score[scene.obstacle].mean() > 4 * score[~scene.obstacle].mean()


def test_the_seed_changes_nothing(scenes: Scenes) -> None:
    _, _, scene = raised_top(scenes, 0.3, 0.35, -1.5)
    stage = GuidedHomography()
    first = scored(stage, scene).tobytes()
    stage.reset(7)
    assert stage.step(scene.flow, scene.planar, Stamp(0)).score.tobytes() == first
