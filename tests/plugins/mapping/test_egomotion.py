"""The motion that is found in the exact flow of a floor, computed by projecting its points."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from graphnav_mapping.egomotion import MIN_VECTORS, Egomotion

from graphnav import Flow, Motion, Plane

from .conftest import COLS, ROWS, Camera, empty_plane, floor_flow

MOTIONS = [(0.03, 0.0), (0.0, 0.12), (0.03, 0.12), (0.02, -0.1), (0.0, 0.0), (-0.02, 0.05)]
ABS_M, ABS_RAD = 5e-4, 1e-3
"""The fit is exact to second order: what is left is a product of three of turn (0.12), displacement and ray."""


def found(before: Camera, now: Camera, plane: Plane | None = None, flow: Flow | None = None, **more: Any) -> Motion:
    stage = Egomotion(
        camera_height_m=now.height_m,
        tilt_deg=now.tilt_deg,
        fov_deg=now.fov_deg,
        camera_forward_m=now.ahead_m,
        **more,
    )
    stage.reset(seed=0)
    motion = stage.step(flow or floor_flow(before, now), plane or empty_plane())
    assert motion is not None
    return motion


def is_right(motion: Motion, chord_m: float, turn_rad: float, abs_m: float = ABS_M, abs_rad: float = ABS_RAD) -> None:
    """Check displacement, along the axes that the robot had before, and turn."""
    assert motion.forward_m == pytest.approx(chord_m * math.cos(turn_rad / 2), abs=abs_m)
    assert motion.left_m == pytest.approx(chord_m * math.sin(turn_rad / 2), abs=abs_m)
    assert motion.turn_rad == pytest.approx(turn_rad, abs=abs_rad)


@pytest.mark.parametrize(("chord_m", "turn_rad"), MOTIONS)
@pytest.mark.parametrize("tilt_deg", [60.0, 75.0, 90.0])
@pytest.mark.parametrize("shakes", [True, False])
def test_motion_of_a_tilted_camera(chord_m: float, turn_rad: float, tilt_deg: float, shakes: bool) -> None:
    before = Camera(0.3, -0.2, 0.7, tilt_deg=tilt_deg)
    is_right(found(before, before.driven(chord_m, turn_rad), shakes=shakes), chord_m, turn_rad)


@pytest.mark.parametrize(("chord_m", "turn_rad"), MOTIONS)
@pytest.mark.parametrize("ahead_m", [0.2, -0.15])
def test_a_camera_off_the_centre_of_turning(chord_m: float, turn_rad: float, ahead_m: float) -> None:
    before = Camera(ahead_m=ahead_m, height_m=0.8)
    is_right(found(before, before.driven(chord_m, turn_rad)), chord_m, turn_rad)


@pytest.mark.parametrize(("chord_m", "turn_rad"), MOTIONS)
@pytest.mark.parametrize("shake_deg", [-0.5, 0.5])
def test_pitch_and_roll_are_told_from_motion(chord_m: float, turn_rad: float, shake_deg: float) -> None:
    before = Camera(pitch_rad=math.radians(shake_deg), roll_rad=-math.radians(shake_deg))
    now = replace(before.driven(chord_m, turn_rad), pitch_rad=0.0, roll_rad=0.0)
    # Half of the shake, 4 mrad, remains as an error of the camera's attitude: of motions and of their like 1 %.
    is_right(found(before, now), chord_m, turn_rad, 1.5e-3, 2e-3)
    if chord_m:
        rigid = found(before, now, shakes=False)
        assert abs(rigid.forward_m - chord_m) > 3e-3


@pytest.mark.parametrize(("chord_m", "turn_rad"), MOTIONS)
@pytest.mark.parametrize("seed", range(3))
def test_two_cells_of_five_may_be_outliers(chord_m: float, turn_rad: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    now = Camera().driven(chord_m, turn_rad)
    flow = floor_flow(Camera(), now)
    wrong = (rng.random((ROWS // 4, COLS // 4)) < 0.4).repeat(4, 0).repeat(4, 1)
    noise_px = rng.uniform(-4.0, 4.0, (ROWS // 4, COLS // 4, 2)).repeat(4, 0).repeat(4, 1)
    uv_px = (flow.uv_px + wrong[..., None] * noise_px).astype(np.float32)
    motion = found(Camera(), now, flow=replace(flow, uv_px=uv_px))
    # An outlier counts where it lies within the noise of a tenth of a pixel, about a millimetre on the floor.
    is_right(motion, chord_m, turn_rad, 1e-3, 2e-3)


def test_what_the_detector_calls_an_obstacle_does_not_count() -> None:
    now = Camera().driven(0.03, 0.05)
    flow, plane = floor_flow(Camera(), now), empty_plane()
    flow.uv_px[:, : COLS * 2 // 3] += 5.0
    plane.obstacle[:, : COLS // 4 * 2 // 3 + 1] = 1
    is_right(found(Camera(), now, plane, flow), 0.03, 0.05)


@pytest.mark.parametrize("why", ["flow", "plane", "obstacle"])
def test_too_few_vectors_give_no_motion(why: str) -> None:
    stage = Egomotion(tilt_deg=60.0)
    stage.reset(seed=0)
    for count, is_enough in ((MIN_VECTORS - 1, False), (MIN_VECTORS, True)):
        # The lowest row of cells is well within the distance that counts.
        counts = np.zeros((ROWS // 4, COLS // 4), np.uint8)
        counts[-1, :count] = 1
        flow, plane = floor_flow(Camera(), Camera().driven(0.03, 0.0)), empty_plane()
        if why == "flow":
            flow = replace(flow, valid=counts.repeat(4, 0).repeat(4, 1))
        elif why == "plane":
            plane = replace(plane, valid=counts)
        else:
            plane = replace(plane, obstacle=1 - counts)
        assert (stage.step(flow, plane) is not None) is is_enough


def test_a_plane_of_another_picture_is_refused() -> None:
    stage = Egomotion()
    stage.reset(seed=0)
    small = np.zeros((10, 10), np.uint8)
    plane = Plane(small, small.astype(np.float32), small + 1, 4, 0.0)
    with pytest.raises(ValueError, match="the flow has 40x30 cells of 4 px, but the plane 10x10: wire the flow"):
        stage.step(floor_flow(Camera(), Camera()), plane)


def test_the_interval_is_that_of_the_flow() -> None:
    assert found(Camera(), Camera().driven(0.01, 0.0)).interval_us == 100_000


@pytest.mark.parametrize("wrong_px", [200.0, 3e38, math.nan, math.inf])
def test_vectors_longer_than_the_picture_do_not_count(wrong_px: float) -> None:
    now = Camera().driven(0.03, 0.05)
    flow = floor_flow(Camera(), now)
    flow.uv_px[:40] = wrong_px
    is_right(found(Camera(), now, flow=flow), 0.03, 0.05)
    flow.uv_px[:] = wrong_px
    stage = Egomotion(tilt_deg=60.0)
    stage.reset(seed=0)
    assert stage.step(flow, empty_plane()) is None
