"""The graph that measures detectors under conditions: its drive, its maps and its models."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import numpy.typing as npt
import pytest
from graphnav_control.nonholonomic import Nonholonomic
from graphnav_flow.truth import Truth as TrueFlow
from graphnav_planar.motion import Motion
from graphnav_steer.oracle import Oracle
from graphnav_world.world import Pymunk, WorldOutputs

from graphnav import Finished, Latest, Map, Recording, Stamp, State, Twist, coarsen
from graphnav.core.graph.find import shipped_folder
from graphnav.core.runner.recording.summary import Summary

Drive = Callable[..., tuple[Summary, Recording]]
MODELS = {
    "tilt_20": 20.0,
    "tilt_35": 35.0,
    "tilt_50": 50.0,
    "tilt_65": 65.0,
    "downward_160x120": 75.0,
    "tilt_80": 80.0,
    "slow": 75.0,
    "fast": 75.0,
    "downward_640x480": 75.0,
}
LARGE = (640, 480)
TICK_US = 100_000


def test_no_condition_of_seeing_changes_the_drive(drive: Drive) -> None:
    model = "planar,subspace_planar,gain_planar,true_planar.model=models/tilt_20.lcmlog"
    _, plain = drive("measure_conditions", 5, "run.until_s=2")
    _, hard = drive(
        "measure_conditions",
        5,
        "run.until_s=2",
        "robot.tilt_deg=20",
        model,
        "robot.contrast_ratio=0.2",
        "robot.exposure_s=0.05",
        "robot.light_swing_ratio=0.3",
        "robot.noise_sigma_gray=8",
    )
    assert _path(plain) == _path(hard)


@pytest.mark.parametrize("tilt_deg", [20.0, 75.0])
def test_the_crowded_way_goes_from_a_free_floor_to_six_tenths_of_obstacle(tilt_deg: float) -> None:
    shares = np.array(_shares(tilt_deg))
    for low in np.arange(0.1, 0.6, 0.1):
        seen = (shares >= low) & (shares < low + 0.1)
        assert np.count_nonzero(seen) >= 5
    assert shares.min() < 0.15


@pytest.mark.parametrize(("model", "tilt_deg"), MODELS.items())
def test_every_model_that_ships_tells_the_floors_flow_at_its_tilt(model: str, tilt_deg: float) -> None:
    size = LARGE if model == "downward_640x480" else (160, 120)
    planar = Motion(model=shipped_folder() / "models" / f"{model}.lcmlog")
    planar.reset(0)
    oracle = TrueFlow()
    oracle.reset(0)
    error_px: list[npt.NDArray[np.floating]] = []
    for out in _floor(tilt_deg, size)[4:]:
        assert out.truth is not None
        assert out.motion is not None
        flow = oracle.step(out.truth)
        told = planar.step(flow, out.motion)
        assert told is not None
        true = coarsen(flow, told.step_px)
        both = (told.planar_valid & true.valid) != 0
        assert both.mean() > 0.6
        error_px.append(np.linalg.norm(told.planar_uv_px - true.uv_px, axis=-1)[both])
    errors = np.concatenate(error_px)
    # Near the horizon the floor is blurred, so that what was taught there errs.
    limit_px = 0.15 if tilt_deg < 30.0 else 0.05
    assert np.median(errors) < limit_px


@cache
def _floor(tilt_deg: float, size: tuple[int, int]) -> list[WorldOutputs]:
    """Return what the world says on an empty floor, driving in turns to both sides."""
    world = Pymunk(map=shipped_folder() / "maps" / "empty.yaml", tilt_deg=tilt_deg, size=size)
    world.reset(7)
    twists = [Twist(v_mps=0.3, omega_radps=0.9 * np.sin(k / 3)) for k in range(20)]
    return [world.step(Latest(twist, 0.1), Stamp(k * TICK_US)) for k, twist in enumerate(twists)]


def _shares(tilt_deg: float) -> list[float]:
    """Return the share of obstacle in every frame of a drive along the planned way."""
    world = Pymunk(map=shipped_folder() / "maps" / "crowded.yaml", tilt_deg=tilt_deg, size=(80, 60))
    steer, control = Oracle(), Nonholonomic(max_speed_mps=0.3)
    for stage in (world, steer, control):
        stage.reset(2)
    twist: Latest[Twist] = Latest()
    around: Map | None = None
    shares: list[float] = []
    for k in range(300):
        try:
            out = world.step(twist, Stamp(k * TICK_US))
        except Finished:
            return shares
        around = out.map or around
        twist = Latest(control.step(steer.step(out.state, Latest(around, 0.0)), Latest(), Stamp(k * TICK_US)), 0.1)
        if out.truth is not None:
            shares.append(float(out.truth.obstacle.mean() / np.isfinite(out.truth.depth_m).mean()))
    raise AssertionError("the goal was not reached")


def _path(log: Recording) -> list[tuple[float, float, float]]:
    states = [log.message("robot.state", k)[2] for k in range(log.count("robot.state"))]
    assert len(states) == 21
    return [(state.x_m, state.y_m, state.yaw_rad) for state in states if isinstance(state, State)]
