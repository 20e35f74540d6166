"""Lamp, glare, shadows and exposure steps: against a plain computation, and truth without them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from graphnav_world.brightness import ExposureSteps
from graphnav_world.geometry.scene import AMBIENT, SUN_W, Body
from graphnav_world.rendering.camera import Camera
from graphnav_world.rendering.lighting import GLOSS, Lighting, Lights
from graphnav_world.rendering.placed_faces import Placed
from graphnav_world.rendering.render import Renderer
from graphnav_world.rendering.shadows import FALL_M, PENUMBRA_M, Caster, Shadows
from graphnav_world.robot import Robot
from graphnav_world.world import Pymunk, WorldOutputs

from graphnav import Latest, ParamError, Stamp, Twist
from graphnav.arrays import Doubles
from graphnav.core.stage import params_of

CAMERA = Camera()
ROBOT = Caster(0.2, 1.0)
Make = Callable[..., tuple[Any, Any]]


def factors(now: Placed, renderer: Renderer, lighting: Lighting, gray: float) -> Doubles:
    """Return lit gray values over those of the world without, where a surface is ``gray``: (rows, cols)."""
    seen = renderer._zbuffer.find(now)
    frame = renderer.render(now, None)
    lit = np.full((CAMERA.rows, CAMERA.cols), gray, np.float32)
    lighting.apply(lit, now, seen, frame.inverse_depth)
    return lit.astype(np.float64)


def geometry(now: Placed, faces: Any, cast: Make) -> tuple[Doubles, Doubles, Doubles]:
    """Return every pixel's surface point in W, its normal, and the shade of its face."""
    face, depth = cast(now.camera, now, faces)
    points = now.eye_W + (now.camera.rays() * depth[..., None]) @ now.R_WC.T
    normals = np.concatenate([faces.normal, [[0.0, 0.0, 1.0]]])[face]
    lambert = np.maximum(normals @ SUN_W, 0.0)
    shade = (AMBIENT + (1 - AMBIENT) * lambert) / (AMBIENT + (1 - AMBIENT) * SUN_W[2])
    return points, normals, shade


@pytest.mark.parametrize("seed", range(3))
def test_lamp_and_glare_are_those_of_the_surface_points(
    seed: int, world: Make, cast: Make, random_bodies: Callable[[int], list[Body]]
) -> None:
    faces, renderer = world(CAMERA, random_bodies(seed))
    now = Placed.at(replace(CAMERA, tilt_deg=76.0, roll_deg=-1.0), faces, 0.1, 0.05, 0.4, time_s=0.7)
    points, normals, shade = geometry(now, faces, cast)
    away = now.eye_W - points
    distance = np.linalg.norm(away, axis=-1)
    incidence = (away * normals).sum(axis=-1) / distance
    off_axis = -(away @ now.R_WC[:, 2]) / distance
    lamp = factors(now, renderer, Lighting(CAMERA, faces, Lights(lamp=1.0), None), 1.0)
    ratio = lamp * shade / (off_axis * incidence / distance**2)
    assert (np.abs(ratio / np.median(ratio) - 1) < 1e-4).mean() > 0.999
    glare = factors(now, renderer, Lighting(CAMERA, faces, Lights(glare=0.8), None), 0.0)
    difference = np.abs(glare - 0.8 * 255 * incidence**GLOSS / distance**2)
    assert (difference < 0.05).mean() > 0.999


def test_a_lamp_leaves_the_mean_of_an_empty_floor(world: Make) -> None:
    for tilt_deg in (75.0, 15.0):
        camera = replace(CAMERA, tilt_deg=tilt_deg)
        faces, renderer = world(camera, [])
        now = Placed.at(camera, faces, 0.0, 0.0, 0.0)
        lit = factors(now, renderer, Lighting(camera, faces, Lights(lamp=0.6), None), 1.0)
        floor = np.isfinite(renderer.render(now, None).depth_m)
        assert lit[floor].mean() == pytest.approx(1.0, abs=1e-4)
        assert lit[~floor].tolist() == [1.0] * int((~floor).sum())


def test_the_reflection_stays_at_the_foot_of_the_mast(maps: Path) -> None:
    frames = drive(maps / "empty.yaml", contrast_ratio=0.0, glare_ratio=0.6)
    pictures = [out.image.pixels for out in frames]
    assert all(np.array_equal(one, pictures[0]) for one in pictures)
    foot = CAMERA.project(np.array([0.0, 0.0, -1.0]) @ CAMERA.R_RC)
    shining = np.argwhere(pictures[0] == pictures[0].max())
    assert pictures[0].max() == 255
    assert shining.mean(axis=0)[::-1] == pytest.approx(foot, abs=1.0)
    assert 20 < len(shining) < 1000


@pytest.mark.parametrize("seed", range(2))
def test_shadows_follow_the_sun_and_stay_in_the_world(
    seed: int, world: Make, cast: Make, random_bodies: Callable[[int], list[Body]]
) -> None:
    faces, renderer = world(CAMERA, random_bodies(seed))
    shadows = Shadows(Caster(1e-9, 1e-9), CAMERA.focal_px, np.random.default_rng(seed))
    lighting = Lighting(CAMERA, faces, Lights(shadow=0.5), shadows)
    at_foot: dict[tuple[int, int], list[float]] = {}
    for x_m, yaw_rad in ((0.0, 0.0), (0.2, 0.5), (-0.1, -0.4)):
        now = Placed.at(CAMERA, faces, x_m, 0.0, yaw_rad)
        points, normals, _ = geometry(now, faces, cast)
        lit = factors(now, renderer, lighting, 1.0)
        sunny = normals @ SUN_W > 0
        assert lit[~sunny] == pytest.approx(1.0)
        feet = points[..., :2] - points[..., 2:] * SUN_W[:2] / SUN_W[2]
        for cell, factor in zip(np.round(feet[sunny] / 0.005).astype(int).tolist(), lit[sunny], strict=True):
            at_foot.setdefault((cell[0], cell[1]), []).append(float(factor))
    assert min(map(min, at_foot.values())) == pytest.approx(0.5)
    assert max(map(max, at_foot.values())) == pytest.approx(1.0)
    spreads = [np.ptp(factors_) for factors_ in at_foot.values() if len(factors_) > 1]
    assert len(spreads) > 1000
    assert np.quantile(spreads, 0.98) < 0.1, "points of one sun ray are 5 mm apart at most, edges are 10 cm wide"


def test_the_robot_carries_its_shadow_along(world: Make, cast: Make) -> None:
    faces, renderer = world(CAMERA, [])
    shadows = Shadows(ROBOT, CAMERA.focal_px, np.random.default_rng(0))
    without = Shadows(Caster(1e-9, 1e-9), CAMERA.focal_px, np.random.default_rng(0))
    for x_m, yaw_rad in ((0.0, 3.7), (1.0, 4.2)):
        now = Placed.at(CAMERA, faces, x_m, 0.0, yaw_rad)
        lit, bare = (
            factors(now, renderer, Lighting(CAMERA, faces, Lights(shadow=0.5), one), 1.0) for one in (shadows, without)
        )
        points, _, _ = geometry(now, faces, cast)
        steps = np.linspace(0.0, 1.0, 400)[:, None] * FALL_M + now.eye_W[:2]
        away_m = np.linalg.norm(points[..., None, :2] - steps, axis=-1).min(axis=-1)
        inside, outside = away_m < ROBOT.radius_m - PENUMBRA_M - 0.005, away_m > ROBOT.radius_m + PENUMBRA_M + 0.005
        assert inside.sum() > 500
        assert lit[inside] == pytest.approx(0.5)
        assert np.array_equal(lit[outside], bare[outside])


def test_exposure_jumps_by_factors_from_the_seed() -> None:
    times_s = np.arange(0.0, 4000.0, 0.1)
    one, same, other = ([s.at(t) for t in times_s] for s in map(steps, (1, 1, 2)))
    assert one == same
    assert one != other
    levels = np.log(np.array(one))
    jumps_s = times_s[1:][np.diff(levels) != 0]
    assert one[0] == 1.0
    assert np.abs(levels).max() == pytest.approx(math.log(1.5), abs=0.01)
    assert np.abs(levels).max() <= math.log(1.5)
    assert levels.mean() == pytest.approx(0.0, abs=0.03)
    gaps_s = np.diff(jumps_s)
    assert gaps_s.min() > 0.89
    assert gaps_s.max() < 3.11
    assert gaps_s.mean() == pytest.approx(2.0, abs=0.05)


@pytest.mark.parametrize("world", [Pymunk, Robot])
@pytest.mark.parametrize("name", ["exposure_step_s", "light_period_s"])
def test_light_that_changes_faster_than_any_picture_shows_is_refused(name: str, world: type[Pymunk | Robot]) -> None:
    period = params_of(world)[name]
    with pytest.raises(ParamError, match=f"'{name}' is 1e-12, but must be >= 0.001 and <= 1000"):
        period.parse(1e-12)
    assert period.parse(0.001) == 0.001


def test_the_fastest_light_leaves_a_drive_its_end(maps: Path) -> None:
    fastest = {"exposure_step_s": 0.001, "exposure_step_ratio": 1.0, "light_period_s": 0.001, "light_swing_ratio": 1.0}
    assert len(drive(maps / "empty.yaml", **fastest)) == 8


def steps(seed: int) -> ExposureSteps:
    return ExposureSteps(0.5, 2.0, np.random.default_rng(seed))


LIGHTS: list[dict[str, Any]] = [
    {"exposure_step_ratio": 0.5, "exposure_step_s": 0.2},
    {"lamp_ratio": 0.7},
    {"glare_ratio": 1.0},
    {"shadow_ratio": 0.5},
]


def drive(map_file: Path, **params: Any) -> list[WorldOutputs]:
    world = Pymunk(map=map_file, noise_sigma_gray=0.0, **params)
    world.reset(3)
    twist = Twist(v_mps=0.4, omega_radps=0.2)
    return [world.step(Latest(twist, 0.1), Stamp(k * 100_000)) for k in range(8)]


@pytest.mark.parametrize("params", LIGHTS, ids=lambda params: next(iter(params)))
def test_light_changes_pictures_but_neither_truth_nor_drive(params: dict[str, Any], maps: Path) -> None:
    plain, lit, again = (drive(maps / "crossing.yaml", **some) for some in ({}, params, params))
    for one, other, same in zip(plain[-3:], lit[-3:], again[-3:], strict=True):
        assert np.array_equal(other.image.pixels, same.image.pixels)
        assert not np.array_equal(one.image.pixels, other.image.pixels)
        assert one.state.x_m == other.state.x_m
        assert one.truth is not None
        assert other.truth is not None
        for field in ("obstacle", "depth_m", "flow_px"):
            assert np.array_equal(getattr(one.truth, field), getattr(other.truth, field))
