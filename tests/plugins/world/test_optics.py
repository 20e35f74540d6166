"""Optics of the simulated camera: rolling shutter, lens, focus, automatic exposure, compression; a rolled mounting."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest
from graphnav_world.brightness import AutoExposure
from graphnav_world.camera_motion import CameraMotion, Shake
from graphnav_world.rendering.camera import Camera
from graphnav_world.rendering.film import Film, disc
from graphnav_world.rendering.lens import Lens
from graphnav_world.rendering.placed_faces import Placed
from graphnav_world.rendering.sensor import Sensor
from graphnav_world.world import Pymunk

from graphnav import ParamError, Twist
from graphnav.arrays import Bools, Bytes, Doubles, Ints
from tests.plugins.world.optics import STANDING, last, lean_errors_px, standing_pictures, undistorted, unprepared_gray

LENSES = [(-0.3, 0.09), (-0.1, 0.0), (0.15, 0.02)]
TURNING = Twist(v_mps=0.3, omega_radps=0.8)


def rays_of(distortion: tuple[float, float]) -> Doubles:
    """Return the rays of a camera with this lens, (rows, cols, 3), by halving what its model says of a radius."""
    camera, (k1, k2) = Camera(tilt_deg=60.0), distortion
    rays = camera.rays()
    distorted = np.hypot(rays[..., 0], rays[..., 1])
    low, high = np.zeros_like(distorted), np.full_like(distorted, 1.4)
    for _ in range(60):
        middle = (low + high) / 2
        is_low = middle * (1 + k1 * middle**2 + k2 * middle**4) < distorted
        low, high = np.where(is_low, middle, low), np.where(is_low, high, middle)
    rays[..., :2] *= (low / distorted)[..., None]
    return rays


def shift_px(one: Bytes, other: Bytes) -> float:
    """Return the displacement between two pictures of the same."""
    size = (one.shape[1], one.shape[0])
    window = cv2.createHanningWindow(size, cv2.CV_64F)
    shift, _ = cv2.phaseCorrelate(one.astype(np.float64), other.astype(np.float64), window)
    return math.hypot(*shift)


# Lens


@pytest.mark.parametrize("distortion", LENSES)
def test_a_lens_looks_where_opencv_says(distortion: tuple[float, float]) -> None:
    camera = Camera(tilt_deg=60.0)
    lens = Lens(camera, *distortion)
    assert lens.fault is None
    x, y = lens.maps
    cx, cy = lens.pinhole.center_px
    rays = np.stack([x - cx, y - cy], axis=-1) / camera.focal_px
    np.testing.assert_allclose(rays, rays_of(distortion)[..., :2], atol=1e-5)
    assert lens.pinhole.focal_px == pytest.approx(camera.focal_px)
    (cx, cy), f = camera.center_px, camera.focal_px
    points = np.concatenate([rays, np.ones((*rays.shape[:2], 1))], axis=-1).reshape(-1, 1, 3).astype(np.float64)
    matrix = np.array([[f, 0.0, cx], [0.0, f, cy], [0.0, 0.0, 1.0]])
    projected, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), matrix, np.array([*distortion, 0.0, 0.0]))
    pixels = np.stack(np.meshgrid(np.arange(camera.cols), np.arange(camera.rows)), axis=-1)
    np.testing.assert_allclose(projected.reshape(pixels.shape), pixels, atol=1e-3)
    np.testing.assert_allclose(lens.distorted_px(np.stack([x, y], axis=-1).astype(np.float64)), pixels, atol=1e-3)


@pytest.mark.parametrize("distortion", LENSES)
def test_mask_and_depth_through_a_lens_are_those_of_its_rays(
    distortion: tuple[float, float], maps: Path, cast: Callable[..., Any]
) -> None:
    outputs = last(Pymunk, maps / "pillars.yaml", tilt_deg=60.0, distortion=distortion)
    assert outputs.truth is not None
    world = Pymunk(map=maps / "pillars.yaml", tilt_deg=60.0)
    world.reset(3)
    camera, state = Camera(tilt_deg=60.0), outputs.state
    rays = rays_of(distortion)
    of_lens = SimpleNamespace(rays=lambda: rays, rows=camera.rows, cols=camera.cols)
    placed = Placed.at(camera, world._faces, state.x_m, state.y_m, state.yaw_rad)
    face, depth_m = cast(of_lens, placed, world._faces)
    obstacle = face >= 0
    assert 0.004 < obstacle.mean() < 0.6
    assert (obstacle != outputs.truth.obstacle).mean() < 0.005, "the nearest pixel's, at edges only"
    inside = (obstacle == outputs.truth.obstacle) & ~_beside_an_edge(face)
    errors = np.abs(outputs.truth.depth_m[inside] / depth_m[inside] - 1)
    assert np.quantile(errors, 0.999) < 1e-5, "exact on a plane"
    assert errors.max() < 0.01, "the nearest pixel's where its neighbours show another face"


@pytest.mark.parametrize("distortion", LENSES)
def test_flow_through_a_lens_ends_where_opencv_projects_the_point(distortion: tuple[float, float], maps: Path) -> None:
    params = {"tilt_deg": 60.0, "distortion": distortion}
    then, now = (last(Pymunk, maps / "pillars.yaml", TURNING, ticks=ticks, **params) for ticks in (6, 7))
    assert now.truth is not None
    camera = Camera(tilt_deg=60.0)
    (R_now, eye_now), (R_then, eye_then) = (
        camera.pose(one.state.x_m, one.state.y_m, one.state.yaw_rad) for one in (now, then)
    )
    points = (rays_of(distortion) * now.truth.depth_m[..., None]) @ R_now.T + eye_now
    points = (points - eye_then) @ R_then
    (cx, cy), f = camera.center_px, camera.focal_px
    matrix = np.array([[f, 0.0, cx], [0.0, f, cy], [0.0, 0.0, 1.0]])
    projected, _ = cv2.projectPoints(
        points.reshape(-1, 1, 3), np.zeros(3), np.zeros(3), matrix, np.array([*distortion, 0.0, 0.0])
    )
    rows, cols = np.indices(points.shape[:2])
    expected = np.stack([cols, rows], axis=-1) - projected.reshape(*points.shape[:2], 2)
    errors = np.linalg.norm(now.truth.flow_px - expected, axis=-1)
    assert np.median(np.linalg.norm(expected, axis=-1)) > 3.0
    assert np.quantile(errors, 0.97) < 0.005, "between pixels of one surface"
    assert errors.max() < 0.3, "at edges, that of the nearest pixel"


@pytest.mark.parametrize("distortion", LENSES)
def test_prepare_undistorts_the_picture(distortion: tuple[float, float], maps: Path, tmp_path: Path) -> None:
    found = undistorted(Pymunk, maps / "pillars.yaml", tmp_path, distortion)
    as_it_is, prepared = unprepared_gray(found)
    assert as_it_is > 5.0
    assert prepared < 0.8
    assert np.abs(found["prepared"].astype(float) - found["pinhole"])[found["prepared"] > 0].mean() < 5.0, (
        "blurred only"
    )


@pytest.mark.parametrize(
    ("distortion", "what"),
    [
        (
            (-0.3, 0.0),
            "'distortion' [-0.3, 0.0] folds the picture back 80 px from its centre, within its corners at 99",
        ),
        ((-0.68, 0.21), "'distortion' [-0.68, 0.21] shows more than a pinhole picture four times as large"),
    ],
)
def test_a_lens_that_makes_no_picture_is_refused(distortion: tuple[float, float], what: str, maps: Path) -> None:
    with pytest.raises(ParamError) as raised:
        Pymunk(map=maps / "empty.yaml", distortion=distortion).check()
    assert (raised.value.param, raised.value.what) == ("distortion", what)
    hint = "give a k1 nearer to 0, a k2 of the other sign such as k1**2, or a smaller fov_deg"
    assert raised.value.hint == hint


def test_the_footprint_of_a_barrel_reaches_farther(maps: Path) -> None:
    narrow, wide = (_footprint(maps, distortion=one) for one in ((0.0, 0.0), (-0.2, 0.04)))
    assert np.abs(wide).max() > 1.1 * np.abs(narrow).max()


# Rolling shutter


@pytest.mark.parametrize("rows", [range(120), range(7), range(41, 60), range(119, 120)])
@pytest.mark.parametrize("extra", [{}, {"lamp_ratio": 0.4, "glare_ratio": 1.0, "shadow_ratio": 0.5}, {"neutral": True}])
def test_rows_are_those_of_the_picture(rows: range, extra: dict[str, Any], maps: Path) -> None:
    world = Pymunk(map=maps / "movers.yaml", tilt_deg=50.0, truth=True, **extra)
    world.reset(3)
    x, y, yaw = world._draw.start
    then, now = (Placed.at(world._camera, world._faces, x + k * 0.03, y, yaw, 0.1 * k) for k in (0, 1))
    complete, part = (world._renderer.render(now, then, rows=one) for one in (None, rows))
    cut = slice(rows.start, rows.stop)
    np.testing.assert_allclose(part.gray, complete.gray[cut], atol=1e-3)
    assert np.array_equal(part.surface, complete.surface[cut])
    np.testing.assert_allclose(part.depth_m, complete.depth_m[cut], rtol=1e-5)
    assert part.flow_px is not None
    assert complete.flow_px is not None
    np.testing.assert_allclose(part.flow_px, complete.flow_px[cut], atol=1e-3)


def test_strips_are_read_from_top_to_bottom_around_the_stamp() -> None:
    sensor = Sensor(Camera(), None, readout_s=0.06)
    for moving_px, count in ((0.0, 1), (0.1, 1), (3.0, 12), (1000.0, 120)):
        strips = sensor.strips(moving_px)
        assert len(strips) == count
        assert [row for strip in strips for row in strip.rows] == list(range(120))
        for strip in strips:
            middle = (strip.rows.start + strip.rows.stop - 1) / 2
            assert strip.after_s == pytest.approx(0.06 * (middle - 59.5) / 119)
    assert (strips[0].after_s, strips[-1].after_s) == pytest.approx((-0.03, 0.03))


def test_an_upright_edge_leans_in_a_turn(tmp_path: Path) -> None:
    assert np.abs(lean_errors_px(Pymunk, tmp_path)).max() <= 1.0


@pytest.mark.parametrize("exposure_s", [0.0, 0.03])
def test_a_robot_that_stands_sees_the_same_through_a_rolling_shutter(exposure_s: float, maps: Path) -> None:
    def make(**params: Any) -> Pymunk:
        return Pymunk(exposure_s=exposure_s, **params)

    one, other = standing_pictures(make, maps / "pillars.yaml", shutter_s=0.06)
    assert one == other


@pytest.mark.parametrize("distortion", [(0.0, 0.0), (-0.2, 0.04)])
def test_each_row_is_that_of_its_own_time(distortion: tuple[float, float], maps: Path) -> None:
    """A turn that is steady: the first row of a frame is the same row of a frame half a readout earlier."""
    params = {"distortion": distortion, "tilt_deg": 90.0, "speed_up_s": 0.01, "turn_up_s": 0.01}
    twist = Twist(v_mps=0.2, omega_radps=0.7)
    rolling = last(Pymunk, maps / "empty.yaml", twist, ticks=6, shutter_s=0.1, **params)
    earlier, later = (last(Pymunk, maps / "empty.yaml", twist, ticks=ticks, **params) for ticks in (5, 6))
    assert rolling.truth is not None
    assert later.truth is not None
    middle = rolling.image.pixels[59:61].astype(float) - later.image.pixels[59:61]
    assert np.abs(middle).mean() < 3.0
    assert np.abs(rolling.image.pixels[:10].astype(float) - later.image.pixels[:10]).mean() > 8.0, "5 px away"
    assert earlier.truth is not None
    np.testing.assert_allclose(rolling.truth.flow_px, later.truth.flow_px, atol=0.02)


def test_a_rolling_shutter_blurs_each_row_by_its_exposure(maps: Path) -> None:
    pictures = [
        last(Pymunk, maps / "empty.yaml", TURNING, ticks=6, shutter_s=0.06, exposure_s=exposure_s).image.pixels
        for exposure_s in (0.0, 0.06)
    ]
    sharp, blurred = (np.abs(np.diff(one.astype(float), axis=0)).mean() for one in pictures)
    assert blurred < 0.8 * sharp
    assert shift_px(*pictures) < 0.5, "around the time of each row"


# Focus, exposure, compression


@pytest.mark.parametrize("radius_px", [0.3, 1.0, 2.5, 4.0])
def test_a_point_out_of_focus_is_a_disc(radius_px: float) -> None:
    kernel = disc(radius_px).astype(np.float64)
    assert kernel.sum() == pytest.approx(1.0, abs=1e-6)
    half = kernel.shape[0] // 2
    y, x = np.mgrid[-half : half + 1, -half : half + 1]
    away = np.hypot(x, y)
    assert not kernel[away > radius_px + math.sqrt(0.5)].any()
    full = away < radius_px - math.sqrt(0.5)
    np.testing.assert_allclose(kernel[full], 1 / (math.pi * radius_px**2), rtol=0.02)


def test_noise_is_as_sharp_as_before_out_of_focus(maps: Path) -> None:
    pictures = [
        last(Pymunk, maps / "empty.yaml", contrast_ratio=0.0, noise_sigma_gray=5.0, defocus_px=radius).image.pixels
        for radius in (0.0, 3.0)
    ]
    one, other = (picture.astype(int) for picture in pictures)
    assert one.std() > 3.0
    assert np.abs(one - other).max() <= 1, "a sum of shares of the same gray, rounded"
    assert (one != other).mean() < 0.01


def test_what_is_out_of_focus_loses_what_is_smaller_than_the_disc(maps: Path) -> None:
    contrasts = [
        cv2.Laplacian(last(Pymunk, maps / "empty.yaml", defocus_px=one).image.pixels, cv2.CV_64F).std()
        for one in (0.0, 1.0, 2.0, 4.0)
    ]
    assert all(nearer > 1.4 * farther for nearer, farther in pairwise(contrasts))


def test_a_compressed_picture_has_blocks(maps: Path) -> None:
    raw, good, poor = (
        last(Pymunk, maps / "empty.yaml", jpeg_quality=quality).image.pixels.astype(float) for quality in (None, 95, 10)
    )
    assert 0.0 < np.abs(good - raw).mean() < 2.0
    assert np.abs(poor - raw).mean() > 4 * np.abs(good - raw).mean()
    steps = np.abs(np.diff(poor, axis=1)).mean(axis=0)
    between = np.arange(len(steps)) % 8 == 7
    assert steps[between].mean() > 1.3 * steps[~between].mean()
    plain = np.abs(np.diff(raw, axis=1)).mean(axis=0)
    assert plain[between].mean() < 1.1 * plain[~between].mean()


def test_the_gain_settles_exponentially_after_a_step_of_light() -> None:
    settle_s, period_s = 0.5, 0.1
    exposure = AutoExposure(100.0, settle_s, (0.1, 10.0))
    means = []
    for k in range(12):
        light_gray = 50.0 if k < 3 else 80.0
        mean = exposure.at(k * period_s, light_gray) * light_gray
        exposure.see(np.full((4, 4), round(mean), np.uint8))
        means.append(mean)
    assert means[:3] == pytest.approx([100.0] * 3, rel=1e-6)
    assert means[3] == pytest.approx(160.0), "a frame is exposed by what was seen before it"
    expected = [100.0 * 1.6 ** math.exp(-k * period_s / settle_s) for k in range(9)]
    assert means[3:] == pytest.approx(expected, rel=0.02)


def test_the_gain_keeps_its_bounds() -> None:
    exposure = AutoExposure(100.0, 0.1, (0.5, 2.0))
    assert exposure.at(0.0, 10.0) == 2.0
    for k, (gray, gain) in enumerate([(0, 2.0), (0, 2.0), (255, 1.2), (255, 0.5)], start=1):
        exposure.see(np.full((4, 4), gray, np.uint8))
        assert exposure.at(10.0 * k, 10.0) == pytest.approx(gain if gain != 1.2 else 2.0 * 100 / 255)


def test_dark_light_is_amplified_with_its_noise(maps: Path) -> None:
    params: dict[str, Any] = {"contrast_ratio": 0.0, "noise_sigma_gray": 2.0, "light_ratio": 0.2}
    fixed, adapted = (
        last(Pymunk, maps / "empty.yaml", auto_exposure_s=one, **params).image.pixels.astype(float)
        for one in (None, 0.5)
    )
    assert adapted.mean() == pytest.approx(110.0, abs=1.0)
    gain = adapted.mean() / fixed.mean()
    assert gain > 3.0
    assert adapted.std() == pytest.approx(gain * fixed.std(), rel=0.05)


def test_what_is_brighter_than_white_is_lost_to_the_gain(maps: Path) -> None:
    params: dict[str, Any] = {"light_ratio": 8.0, "auto_exposure_s": 0.5}
    clipped, bounded = (
        last(Pymunk, maps / "empty.yaml", auto_exposure_gain_ratio=one, **params).image.pixels
        for one in ((0.01, 8.0), (1.0, 8.0))
    )
    assert clipped.mean() == pytest.approx(110.0, rel=0.1), "darker before it is clipped"
    assert (clipped == 255).mean() < 0.01
    assert (bounded == 255).mean() > 0.9


def test_a_gain_without_room_is_refused(maps: Path) -> None:
    with pytest.raises(ParamError, match="is empty"):
        Pymunk(map=maps / "empty.yaml", auto_exposure_gain_ratio=(2.0, 1.0)).check()


# Rolled mounting


def test_the_lower_side_of_a_rolled_camera_sees_what_is_near(maps: Path) -> None:
    outputs = last(Pymunk, maps / "empty.yaml", camera_roll_deg=10.0)
    assert outputs.truth is not None
    depth_m = outputs.truth.depth_m
    camera = Camera(roll_deg=10.0)
    np.testing.assert_allclose(depth_m, 1 / -(camera.rays() @ camera.R_RC[2]), rtol=1e-5)
    assert depth_m[60, -1] < depth_m[60, 0]
    left_m, right_m = (
        _footprint(maps, camera_roll_deg=10.0)[:, 1].max(),
        -_footprint(maps, camera_roll_deg=10.0)[:, 1].min(),
    )
    assert left_m > 1.2 * right_m


def test_a_rolled_camera_shakes_about_its_mounting() -> None:
    motion = CameraMotion(Camera(roll_deg=4.0), Shake(0.5, 0.0, 0.1), np.random.default_rng(0))
    rolls = [motion.at(float(k)).roll_deg for k in range(400)]
    assert np.mean(rolls) == pytest.approx(4.0, abs=0.1)
    assert np.std(rolls) == pytest.approx(0.5, rel=0.15)


def test_film_without_optics_leaves_a_picture_as_it_is() -> None:
    gray = np.full((4, 4), 40.0, np.float32)
    film = Film()
    assert film.blurred(gray) is gray
    pixels = film.exposed(gray)
    assert film.compressed(pixels) is pixels


def _footprint(maps: Path, **params: Any) -> Doubles:
    outputs = last(Pymunk, maps / "empty.yaml", STANDING, ticks=1, **params)
    assert outputs.map is not None
    return outputs.map.footprint_m


def _beside_an_edge(face: Ints) -> Bools:
    kernel, picture = np.ones((3, 3), np.uint8), face.astype(np.float32)
    return np.asarray(cv2.dilate(picture, kernel) != cv2.erode(picture, kernel))
