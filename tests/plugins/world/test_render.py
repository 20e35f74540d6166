"""The renderer against a ray caster, against projected points and against itself a frame later."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
import pytest
from graphnav_world.geometry import outlines
from graphnav_world.geometry.scene import Body
from graphnav_world.rendering import visibility
from graphnav_world.rendering.camera import Camera
from graphnav_world.rendering.film import Film
from graphnav_world.rendering.placed_faces import Placed
from graphnav_world.rendering.render import Frame

from graphnav.arrays import Bytes, Doubles

CAMERA = Camera()
Make = Callable[..., tuple[Any, Any]]


@pytest.mark.parametrize("seed", range(12))
def test_every_pixel_shows_the_face_that_its_ray_hits_first(
    seed: int, world: Make, cast: Make, random_bodies: Callable[[int], list[Body]]
) -> None:
    faces, renderer = world(CAMERA, random_bodies(seed))
    for yaw in (0.0, 2.0):
        placed = Placed.at(CAMERA, faces, 0.1, 0.05, yaw, time_s=0.7)
        frame = renderer.render(placed, None)
        face, depth = cast(CAMERA, placed, faces)
        same = frame.surface == face
        assert (~same).mean() < 0.0005, "rounding may move a pixel on an edge, no more"
        np.testing.assert_allclose(frame.depth_m[same], depth[same], rtol=1e-5)


def test_a_low_camera_that_sees_the_horizon_and_walls_behind_it_is_exact_too(
    world: Make, cast: Make, random_bodies: Callable[[int], list[Body]]
) -> None:
    camera = Camera(height_m=0.7, tilt_deg=15.0, fov_deg=90.0)
    faces, renderer = world(camera, random_bodies(3))
    placed = Placed.at(camera, faces, 0.1, 0.05, 0.3)
    frame = renderer.render(placed, placed)
    face, depth = cast(camera, placed, faces)
    assert (frame.surface != face).mean() < 0.0005
    sky = np.isinf(depth)
    assert sky.any()
    assert np.array_equal(np.isinf(frame.depth_m), sky)
    assert not frame.obstacle[sky].any()
    assert np.array_equal(frame.obstacle == 1, frame.surface >= 0)
    assert np.abs(frame.flow_px).max() < 1e-3, "what does not move does not flow, the sky neither"


@pytest.mark.parametrize("side", [-1.0, 1.0], ids=["right", "left"])
@pytest.mark.parametrize("few", [0, 32])
def test_a_wall_that_fills_rows_and_passes_beside_the_eye_is_exact(
    side: float, few: int, world: Make, cast: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All its edges bound it on one side: nothing else ends its spans at the rim of the picture."""
    monkeypatch.setattr(visibility, "FEW_PRIMS", few)
    camera = Camera(height_m=0.5, tilt_deg=20.0, fov_deg=30.0, cols=40, rows=30)
    line = outlines.strip(np.array([[-2.0, side * 0.3], [4.0, side * 0.3]]), 0.1, closed=False)
    faces, renderer = world(camera, [Body.wall(line, 1.2, "wall")])
    for yaw in (0.3, 0.5, 1.0):
        placed = Placed.at(camera, faces, 0.0, 0.0, side * yaw)
        frame = renderer.render(placed, None)
        face, depth = cast(camera, placed, faces)
        assert (face >= 0).any()
        assert np.array_equal(frame.surface, face)
        np.testing.assert_allclose(frame.depth_m, depth, rtol=1e-5)


@pytest.mark.parametrize("tilt_deg", [75.0, 15.0])
def test_a_view_of_many_bodies_is_that_of_few(
    tilt_deg: float, world: Make, random_bodies: Callable[[int], list[Body]], monkeypatch: pytest.MonkeyPatch
) -> None:
    camera = Camera(tilt_deg=tilt_deg)
    faces, renderer = world(camera, random_bodies(5))
    placed = Placed.at(camera, faces, 0.1, 0.05, 0.3, time_s=0.7)
    frames = []
    for few in (0, len(faces.quads)):
        monkeypatch.setattr(visibility, "FEW_PRIMS", few)
        frames.append(renderer.render(placed, None))
    many, few_prims = frames
    assert many.obstacle.any()
    assert np.array_equal(many.surface, few_prims.surface)
    assert np.array_equal(many.pixels, few_prims.pixels)


def test_the_tops_of_low_walls_are_seen(world: Make) -> None:
    wall = Body.wall(outlines.strip(np.array([[-2.0, 0.5], [2.0, 0.5]]), 0.1, closed=False), 0.3, "wall")
    faces, renderer = world(CAMERA, [wall])
    frame = renderer.render(Placed.at(CAMERA, faces, 0.0, 0.0, 0.0), None)
    seen = {tuple(np.round(faces.normal[face])) for face in np.unique(frame.surface) if face >= 0}
    assert seen == {(0, -1, 0), (0, 0, 1)}
    top = faces.normal[frame.surface][..., 2] == 1
    height = CAMERA.height_m + frame.depth_m * (CAMERA.rays() @ CAMERA.R_RC[2])
    np.testing.assert_allclose(height[top & (frame.surface >= 0)], 0.3, atol=1e-5)


def test_an_empty_floor_has_no_obstacle(world: Make) -> None:
    faces, renderer = world(CAMERA, [])
    frame = renderer.render(Placed.at(CAMERA, faces, 0.0, 0.0, 0.0), None)
    assert not frame.obstacle.any()
    assert (frame.surface == -1).all()


def test_flow_of_the_floor_is_that_of_its_homography(world: Make) -> None:
    faces, renderer = world(CAMERA, [])
    then, now = Placed.at(CAMERA, faces, 0.3, 0.2, 0.5), Placed.at(CAMERA, faces, 0.33, 0.215, 0.62)
    flow = renderer.render(now, then).flow_px
    H = _floor_to_pixels(then) @ np.linalg.inv(_floor_to_pixels(now))
    x, y = np.meshgrid(np.arange(CAMERA.cols), np.arange(CAMERA.rows))
    before = np.stack([x, y, np.ones_like(x)], axis=-1) @ H.T
    expected = np.stack([x, y], axis=-1) - before[..., :2] / before[..., 2:]
    np.testing.assert_allclose(flow, expected, atol=2e-4)


@pytest.mark.parametrize("seed", range(4))
def test_flow_is_how_far_the_point_behind_the_pixel_has_moved(
    seed: int, world: Make, cast: Make, random_bodies: Callable[[int], list[Body]]
) -> None:
    faces, renderer = world(CAMERA, random_bodies(seed))
    then = Placed.at(CAMERA, faces, 0.1, 0.0, 0.1, time_s=0.4)
    now = Placed.at(CAMERA, faces, 0.14, 0.02, 0.2, time_s=0.5)
    frame = renderer.render(now, then)
    face, depth = cast(CAMERA, now, faces)
    points = now.eye_W + (CAMERA.rays() * depth[..., None]) @ now.R_WC.T
    moved = {body: here - there for (body, here), (_, there) in zip(now.moving, then.moving, strict=True)}
    body = np.where(face >= 0, faces.body[face], -1)
    for index, shift in moved.items():
        assert np.linalg.norm(shift) > 0.01
        points[body == index] -= shift
    before = CAMERA.project((points - then.eye_W) @ then.R_WC)
    x, y = np.meshgrid(np.arange(CAMERA.cols), np.arange(CAMERA.rows))
    expected = np.stack([x, y], axis=-1) - before
    same = frame.surface == face
    np.testing.assert_allclose(frame.flow_px[same], expected[same], atol=1e-3)


def test_a_moving_obstacle_brings_its_own_motion_and_its_texture_along(
    world: Make, random_bodies: Callable[[int], list[Body]]
) -> None:
    faces, renderer = world(CAMERA, random_bodies(1)[-1:])
    path = faces.movers[0]
    x, y = path.at(0.0)
    pose = (x - 0.35, y, 0.0)
    then, now = (Placed.at(CAMERA, faces, *pose, time_s=t) for t in (0.0, 0.1))
    before, frame = renderer.render(then, None), renderer.render(now, then)
    on_it = frame.obstacle == 1
    assert on_it.mean() > 0.03
    assert (np.linalg.norm(frame.flow_px[on_it], axis=-1) > 1.0).all()
    assert np.abs(frame.flow_px[~on_it]).max() < 1e-3
    assert _unexplained(before, frame, frame.obstacle) < 3.0


@pytest.mark.parametrize("yaw_rad", [0.05, 0.3])
def test_textures_stick_to_their_surfaces(
    yaw_rad: float, world: Make, random_bodies: Callable[[int], list[Body]]
) -> None:
    faces, renderer = world(CAMERA, random_bodies(5))
    then, now = Placed.at(CAMERA, faces, 0.0, 0.0, 0.0), Placed.at(CAMERA, faces, 0.03, 0.0, yaw_rad)
    before, frame = renderer.render(then, None), renderer.render(now, then)
    floor = 1 - frame.obstacle
    assert _unexplained(before, frame, floor) < 3.0, "resampling blurs, nothing more"
    assert _unexplained(before, frame, frame.obstacle) < 4.0
    assert np.abs(frame.pixels[floor == 1] - before.pixels[floor == 1].astype(float)).mean() > 10.0, "it did move"


def test_a_floor_shows_no_pattern_twice(world: Make) -> None:
    camera = Camera(cols=320, rows=240, height_m=1.6, tilt_deg=90.0)
    faces, renderer = world(camera, [])
    view = renderer.render(Placed.at(camera, faces, 0.0, 0.0, 0.0), None).pixels.astype(np.float32)
    view -= view.mean()
    power = np.abs(np.fft.rfft2(view, s=(480, 640))) ** 2
    overlap = np.fft.irfft2(np.abs(np.fft.rfft2(np.ones_like(view), s=(480, 640))) ** 2)
    correlation = np.fft.irfft2(power) / np.maximum(overlap, 1.0) / view.var()
    lag_y, lag_x = np.minimum(np.arange(480), 480 - np.arange(480)), np.minimum(np.arange(640), 640 - np.arange(640))
    beyond_a_grain = np.hypot(lag_y[:, None], lag_x) > 30
    enough_overlap = overlap > view.size / 4
    assert correlation[beyond_a_grain & enough_overlap].max() < 0.35


def test_far_textures_do_not_alias(world: Make) -> None:
    near, far = Camera(height_m=1.0, tilt_deg=90.0), Camera(height_m=8.0, tilt_deg=90.0)
    flicker = []
    for camera in (near, far):
        faces, renderer = world(camera, [])
        step = 0.5 * camera.height_m / camera.focal_px
        then, now = Placed.at(camera, faces, 0.0, 0.0, 0.0), Placed.at(camera, faces, step, 0.0, 0.0)
        before, frame = renderer.render(then, None), renderer.render(now, then)
        flicker.append(_unexplained(before, frame, np.ones_like(frame.obstacle)) / frame.pixels.std())
    assert flicker[1] < 0.35, "half a pixel of motion keeps a blurred texture alike; an aliased one flickers"
    assert flicker[0] < 0.2


def test_noise_has_the_asked_spread_and_comes_from_the_seed(world: Make) -> None:
    faces, renderer = world(CAMERA, [])
    placed = Placed.at(CAMERA, faces, 0.0, 0.0, 0.0)
    clean = renderer.render(placed, None).pixels.astype(float)
    one, same, other = (
        Film(noise_sigma_gray=5.0, rng=np.random.default_rng(seed)).exposed(renderer.render(placed, None).gray)
        for seed in (1, 1, 2)
    )
    assert (one == same).all()
    assert (one != other).any()
    assert (one - clean).std() == pytest.approx(5.0, rel=0.05)
    assert (one - clean).mean() == pytest.approx(0.0, abs=0.2)


def test_light_makes_brighter(world: Make) -> None:
    faces, renderer = world(CAMERA, [])
    placed = Placed.at(CAMERA, faces, 0.0, 0.0, 0.0)
    dim, normal = (Film(light).exposed(renderer.render(placed, None).gray).mean() for light in (0.5, 1.0))
    assert dim == pytest.approx(normal / 2, rel=0.01)


def _floor_to_pixels(placed: Placed) -> Doubles:
    """Return the homography from (x_m, y_m, 1) on the floor to pixels."""
    cx, cy = CAMERA.center_px
    K = np.array([[CAMERA.focal_px, 0, cx], [0, CAMERA.focal_px, cy], [0, 0, 1]])
    R_CW = placed.R_WC.T
    return K @ np.column_stack([R_CW[:, 0], R_CW[:, 1], -R_CW @ placed.eye_W])


def _unexplained(before: Frame, frame: Frame, mask: Bytes) -> float:
    """Return the mean gray difference to the last frame warped by the true flow, where it saw the same surface."""
    assert frame.flow_px is not None
    rows, cols = frame.pixels.shape
    x, y = np.meshgrid(np.arange(cols, dtype=np.float32), np.arange(rows, dtype=np.float32))
    from_x, from_y = x - frame.flow_px[..., 0], y - frame.flow_px[..., 1]
    warped = cv2.remap(before.pixels.astype(np.float32), from_x, from_y, cv2.INTER_CUBIC)
    face = cv2.remap(before.surface.astype(np.float32), from_x, from_y, cv2.INTER_NEAREST, borderValue=-2)
    inside = (from_x > 2) & (from_x < cols - 3) & (from_y > 2) & (from_y < rows - 3)
    same = (face == frame.surface).astype(np.uint8) * inside.astype(np.uint8) * mask.astype(np.uint8)
    same = cv2.erode(same, np.ones((5, 5), np.uint8)).astype(bool)
    assert same.sum() > 100
    return float(np.abs(warped - frame.pixels)[same].mean())
