"""Camera shake: its statistics, and the truth of a camera that pitches, rolls and bobs."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from graphnav_world.camera_motion import CameraMotion, Shake
from graphnav_world.geometry.scene import Body
from graphnav_world.rendering.camera import Camera
from graphnav_world.rendering.placed_faces import Placed
from graphnav_world.robot import Robot
from graphnav_world.world import Pymunk, WorldOutputs

from graphnav import Latest, Stamp, Twist
from graphnav.arrays import Doubles
from graphnav.core.codec import encode

REST = Camera()
TWIST = Twist(v_mps=0.3, omega_radps=0.3)
SHAKEN: dict[str, Any] = {"camera_shake_deg": 1.0, "camera_bob_ratio": 0.03}
Make = Callable[..., tuple[Any, Any]]


def drive(map_file: Path, ticks: int = 8, seed: int = 3, **params: Any) -> list[WorldOutputs]:
    world = Pymunk(map=map_file, **params)
    world.reset(seed)
    return [world.step(Latest(TWIST, 0.1), Stamp(k * 100_000)) for k in range(ticks)]


def history(times_s: Doubles, correlation_s: float = 0.2) -> Doubles:
    """Return pitch (deg), roll (deg) and height (m) at these times, (times, 3)."""
    motion = CameraMotion(REST, Shake(0.5, 0.03, correlation_s), np.random.default_rng(0))
    cameras = [motion.at(time_s) for time_s in times_s.tolist()]
    return np.array([[one.tilt_deg - 75.0, one.roll_deg, one.height_m - 1.0] for one in cameras])


def test_pitch_roll_and_height_spread_as_asked_and_are_independent() -> None:
    moved = history(np.arange(0.0, 10_000.0, 0.5))
    assert moved.mean(axis=0) == pytest.approx([0.0, 0.0, 0.0], abs=0.02)
    assert moved.std(axis=0) == pytest.approx([0.5, 0.5, 0.03], rel=0.03)
    assert np.abs(np.corrcoef(moved.T) - np.eye(3)).max() < 0.03


@pytest.mark.parametrize("periods_s", [(0.01, 0.01), (0.1, 0.1), (0.02, 0.18)], ids=["fast", "slow", "irregular"])
def test_the_correlation_decays_with_time_not_with_frames(periods_s: tuple[float, float]) -> None:
    times_s: Doubles = np.cumsum(np.tile(periods_s, 20_000))
    moved = history(times_s)
    for k, gap_s in enumerate(periods_s):
        then, now = moved[k:-1:2], moved[k + 1 :: 2]
        n = min(len(then), len(now))
        following_s = periods_s[1 - k]
        found = [np.corrcoef(then[:n, axis], now[:n, axis])[0, 1] for axis in range(3)]
        assert found == pytest.approx([math.exp(-following_s / 0.2)] * 3, abs=0.03), gap_s


def test_a_shaken_camera_is_turned_about_the_axes_of_the_robot() -> None:
    camera = replace(REST, tilt_deg=REST.tilt_deg + 2.0, roll_deg=-3.0, height_m=1.1)
    pitch, _ = cv2.Rodrigues(np.array([0.0, math.radians(2.0), 0.0]))
    roll, _ = cv2.Rodrigues(np.array([math.radians(-3.0), 0.0, 0.0]))
    yaw, _ = cv2.Rodrigues(np.array([0.0, 0.0, 0.7]))
    R_WC, eye_W = camera.pose(1.0, 2.0, 0.7)
    np.testing.assert_allclose(R_WC, yaw @ roll @ pitch @ REST.R_RC, atol=1e-12)
    assert eye_W.tolist() == [1.0, 2.0, 1.1]


@pytest.mark.parametrize("seed", range(3))
def test_picture_and_truth_of_a_shaken_camera_are_exact(
    seed: int, world: Make, cast: Make, random_bodies: Callable[[int], list[Body]]
) -> None:
    faces, renderer = world(REST, random_bodies(seed))
    cameras = [
        replace(REST, tilt_deg=REST.tilt_deg + pitch, roll_deg=roll, height_m=height)
        for pitch, roll, height in ((1.5, -2.0, 0.97), (-1.0, 1.0, 1.04))
    ]
    then = Placed.at(cameras[0], faces, 0.1, 0.0, 0.1, time_s=0.4)
    now = Placed.at(cameras[1], faces, 0.14, 0.02, 0.2, time_s=0.5)
    before, frame = renderer.render(then, None), renderer.render(now, then)
    face, depth = cast(cameras[1], now, faces)
    same = frame.surface == face
    assert (~same).mean() < 0.0005
    np.testing.assert_allclose(frame.depth_m[same], depth[same], rtol=1e-5)
    points = now.eye_W + (REST.rays() * depth[..., None]) @ now.R_WC.T
    moved = {body: here - there for (body, here), (_, there) in zip(now.moving, then.moving, strict=True)}
    body = np.where(face >= 0, faces.body[face], -1)
    for index, shift in moved.items():
        points[body == index] -= shift
    x, y = np.meshgrid(np.arange(REST.cols, dtype=np.float32), np.arange(REST.rows, dtype=np.float32))
    expected = np.stack([x, y], axis=-1) - REST.project((points - then.eye_W) @ then.R_WC)
    np.testing.assert_allclose(frame.flow_px[same], expected[same], atol=1e-3)
    unmoved = renderer.render(Placed.at(REST, faces, 0.14, 0.02, 0.2, 0.5), Placed.at(REST, faces, 0.1, 0.0, 0.1, 0.4))
    assert np.abs(frame.flow_px - unmoved.flow_px).mean() > 2.0
    from_x, from_y = x - frame.flow_px[..., 0], y - frame.flow_px[..., 1]
    warped = cv2.remap(before.pixels.astype(np.float32), from_x, from_y, cv2.INTER_CUBIC)
    faces_then = cv2.remap(before.surface.astype(np.float32), from_x, from_y, cv2.INTER_NEAREST, borderValue=-2)
    seen_then = cv2.erode((faces_then == frame.surface).astype(np.uint8), np.ones((5, 5), np.uint8)) == 1
    assert seen_then.mean() > 0.3
    assert np.abs(warped - frame.pixels)[seen_then].mean() < 4.0, "resampling blurs, nothing more"


def test_only_the_camera_shakes(maps: Path) -> None:
    steady, shaken = drive(maps / "crossing.yaml"), drive(maps / "crossing.yaml", **SHAKEN)
    assert [out.state.x_m for out in steady] == [out.state.x_m for out in shaken]
    one, other = steady[0].map, shaken[0].map
    assert one is not None
    assert other is not None
    assert np.array_equal(one.footprint_m, other.footprint_m)
    for before, now in zip(steady[1:], shaken[1:], strict=True):
        assert before.motion is not None
        assert now.motion is not None
        assert encode(before.motion, 0, 0) == encode(now.motion, 0, 0)
        assert before.truth is not None
        assert now.truth is not None
        assert np.abs(before.truth.flow_px - now.truth.flow_px).mean() > 0.1
        assert not np.array_equal(before.truth.depth_m, now.truth.depth_m)


def test_the_seed_decides_the_shake(maps: Path) -> None:
    one, same, other = (drive(maps / "empty.yaml", 3, seed, **SHAKEN) for seed in (3, 3, 4))
    assert np.array_equal(one[-1].image.pixels, same[-1].image.pixels)
    depths = [out[-1].truth.depth_m.mean() for out in (one, other) if out[-1].truth is not None]
    assert depths[0] != depths[1]


def test_the_robot_on_a_bus_shakes_as_the_world_does(maps: Path) -> None:
    params: dict[str, Any] = {"map": maps / "empty.yaml", "noise_sigma_gray": 0.0, **SHAKEN}
    pictures = []
    for stage, period_us in ((Pymunk(**params), 100_000), (Robot(**params), 10_000)):
        stage.reset(3)
        seen = [stage.step(Latest(), Stamp(t_us)).image for t_us in range(0, 500_001, period_us)]
        pictures.append(np.stack([image.pixels for image in seen if image is not None]))
    of_world, of_robot = pictures
    assert np.array_equal(of_world, of_robot)
