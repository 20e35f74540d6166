"""The true planar flow is the floor's, also where something stands on it."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from graphnav_planar.truth import Truth
from graphnav_world.rendering.camera import Camera
from graphnav_world.world import Pymunk

import graphnav
from graphnav import Latest, Stamp, State, Twist
from graphnav.arrays import Bools, Doubles
from graphnav.core.graph.find import shipped_folder
from graphnav.testing import check_stage

TWISTS = [(0.3, 0.0), (0.0, 1.5), (0.3, 1.0), (0.2, -1.5), (0.0, 0.0)]


@cache
def drive(world_map: str, tilt_deg: float = 75.0) -> list[tuple[graphnav.Truth, State, State]]:
    """Return the truth of each frame of a drive, with the states of the frame and of the one before."""
    world = Pymunk(map=shipped_folder() / "maps" / world_map, tilt_deg=tilt_deg)
    world.reset(4)
    before = world.step(Latest(), Stamp(0)).state
    frames = []
    for frame, (v_mps, omega_radps) in enumerate(TWISTS, start=1):
        seen = world.step(Latest(Twist(v_mps=v_mps, omega_radps=omega_radps), 0.0), Stamp(100_000 * frame))
        assert seen.truth is not None
        frames.append((seen.truth, before, seen.state))
        before = seen.state
    return frames


def floor_flow(camera: Camera, before: State, now: State) -> tuple[Doubles, Bools]:
    """Return the floor's flow by the world's geometry, and where a pixel's ray meets the floor."""
    R_WC, eye = camera.pose(now.x_m, now.y_m, now.yaw_rad)
    rays = camera.rays() @ R_WC.T
    meets = rays[..., 2] < 0
    points = eye + rays * (-eye[2] / np.where(meets, rays[..., 2], -np.inf))[..., None]
    R_WC_then, eye_then = camera.pose(before.x_m, before.y_m, before.yaw_rad)
    now_px = np.stack(np.meshgrid(np.arange(camera.cols), np.arange(camera.rows)), axis=-1)
    seen_then = np.where(meets[..., None], (points - eye_then) @ R_WC_then, 1.0)
    return np.where(meets[..., None], now_px - camera.project(seen_then), 0.0), meets


@pytest.mark.parametrize("world_map", ["empty.yaml", "crossing.yaml", "corridor_ccw.yaml"])
def test_it_is_the_flow_of_the_floor_also_behind_obstacles(world_map: str) -> None:
    stage = Truth(cell_px=1)
    for truth, before, now in drive(world_map):
        planar = stage.step(truth)
        exact, _ = floor_flow(Camera(), before, now)
        assert planar.planar_valid.all()
        assert planar.planar_uv_px == pytest.approx(exact, abs=1e-3)


@pytest.mark.parametrize("tilt_deg", [20.0, 35.0])
def test_it_ends_at_the_horizon(tilt_deg: float) -> None:
    stage = Truth(cell_px=1)
    for truth, before, now in drive("corridor_ccw.yaml", tilt_deg):
        planar = stage.step(truth)
        exact, meets = floor_flow(Camera(tilt_deg=tilt_deg), before, now)
        assert np.array_equal(planar.planar_valid != 0, meets)
        assert planar.planar_uv_px == pytest.approx(exact, abs=1e-3)


def test_cells_hold_the_mean_of_their_pixels() -> None:
    fine, coarse = Truth(cell_px=1), Truth()
    truth, *_ = drive("crossing.yaml")[0]
    pixels, cells = fine.step(truth), coarse.step(truth)
    assert cells.planar_uv_px.shape == (30, 40, 2)
    assert cells.step_px == 4
    expected = pixels.planar_uv_px.reshape(30, 4, 40, 4, 2).mean(axis=(1, 3))
    assert cells.planar_uv_px == pytest.approx(expected, abs=1e-5)


def test_a_thinned_truth_gives_the_same_flow() -> None:
    truth, *_ = drive("crossing.yaml")[0]
    thin = graphnav.Truth(
        obstacle=truth.obstacle[::4, ::4],
        depth_m=truth.depth_m[::4, ::4],
        flow_px=truth.flow_px[::4, ::4],
        interval_us=truth.interval_us,
        step_px=4,
    )
    full = Truth(cell_px=1).step(truth).planar_uv_px[::4, ::4]
    assert Truth().step(thin).planar_uv_px == pytest.approx(full, abs=1e-3)


@pytest.mark.parametrize("ground_px", [0, 3, 150])
def test_too_little_ground_tells_nothing(ground_px: int) -> None:
    truth, *_ = drive("empty.yaml")[0]
    covered = np.ones(truth.obstacle.size, np.uint8)
    covered[:ground_px] = 0
    planar = Truth().step(
        graphnav.Truth(
            obstacle=covered.reshape(truth.obstacle.shape),
            depth_m=truth.depth_m,
            flow_px=truth.flow_px,
            interval_us=truth.interval_us,
        )
    )
    assert not planar.planar_valid.any()
    assert not planar.planar_uv_px.any()


def test_ground_on_one_line_tells_nothing() -> None:
    truth, *_ = drive("empty.yaml")[0]
    covered = np.ones_like(truth.obstacle)
    covered[60] = 0
    line = graphnav.Truth(obstacle=covered, depth_m=truth.depth_m, flow_px=truth.flow_px, interval_us=100_000)
    assert not Truth(min_ground_ratio=0.001).step(line).planar_valid.any()


def test_the_stage_keeps_its_contract() -> None:
    check_stage(Truth, *({"truth": truth} for truth, *_ in drive("crossing.yaml")))
