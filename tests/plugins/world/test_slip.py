"""Wheels that slip: the robot falls behind what they tell."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from graphnav_world.robot import Robot
from graphnav_world.slip import Slip
from graphnav_world.world import Pymunk

from graphnav import Latest, Stamp, Twist
from graphnav.arrays import Doubles
from graphnav.testing import check_stage

CURVE = Twist(v_mps=0.4, omega_radps=0.5)
PARAMS: dict[str, Any] = {"size": (32, 24), "odometry_scale_ratio": 0.0, "odometry_noise_ratio": 0.0}


def shares(mean_ratio: float, correlation_s: float, steps: int, dt_s: float = 0.01) -> Doubles:
    """Return the lost shares of both motions, float64 (steps, 2)."""
    slip = Slip(np.random.default_rng(1), mean_ratio, correlation_s, (0.0, 0.0, 0.0))
    kept: Doubles = np.array([slip.roll(1.0, 1.0, dt_s) for _ in range(steps)])
    return 1 - kept


def test_shares_are_uniform_from_zero_to_twice_their_mean() -> None:
    lost = shares(0.15, correlation_s=0.01, steps=20_000)
    assert lost.min() >= 0.0
    assert lost.max() <= 0.3
    # A sample mean of 20 000 values that are correlated over about two steps is good to 1 %.
    assert lost.mean(axis=0) == pytest.approx([0.15, 0.15], rel=0.03)
    assert lost.std(axis=0) == pytest.approx([0.3 / math.sqrt(12)] * 2, rel=0.03)


def test_forward_and_turn_slip_independently() -> None:
    forward, turn = shares(0.2, correlation_s=0.01, steps=20_000).T
    assert abs(np.corrcoef(forward, turn)[0, 1]) < 0.03


@pytest.mark.parametrize("dt_s", [0.01, 0.05])
def test_it_is_correlated_over_the_correlation_time_whatever_the_step(dt_s: float) -> None:
    lost = shares(0.2, correlation_s=0.5, steps=40_000, dt_s=dt_s)[:, 0]
    lag = round(0.5 / dt_s)
    # Of the underlying normal process it is 1/e; ranks of a bivariate normal have 6/pi asin(r/2).
    expected = 6 / math.pi * math.asin(math.exp(-1) / 2)
    assert np.corrcoef(lost[:-lag], lost[lag:])[0, 1] == pytest.approx(expected, abs=0.1)


def test_the_wheels_are_where_the_robot_would_be_without_slip(maps: Path) -> None:
    outputs = {}
    for slip_ratio in (0.0, 0.2):
        world = Pymunk(map=maps / "empty.yaml", slip_ratio=slip_ratio, **PARAMS)
        world.reset(3)
        outputs[slip_ratio] = [world.step(Latest(CURVE, 0.1), Stamp(k * 100_000)) for k in range(30)]
    for plain, slipping in zip(outputs[0.0][1:], outputs[0.2][1:], strict=True):
        assert plain.motion is not None
        assert slipping.motion is not None
        assert slipping.motion.forward_m == pytest.approx(plain.motion.forward_m, abs=1e-9)
        assert slipping.motion.left_m == pytest.approx(plain.motion.left_m, abs=1e-9)
        assert slipping.motion.turn_rad == pytest.approx(plain.motion.turn_rad, abs=1e-9)
        assert slipping.state.v_mps < plain.state.v_mps
        assert slipping.state.omega_radps < plain.state.omega_radps
    turned = [math.remainder(out[-1].state.yaw_rad - out[0].state.yaw_rad, 2 * math.pi) for out in outputs.values()]
    assert 0.6 * turned[0] < turned[1] < turned[0]


def test_the_state_is_the_truth(maps: Path) -> None:
    world = Pymunk(map=maps / "empty.yaml", slip_ratio=0.3, slip_correlation_s=30.0, **PARAMS)
    world.reset(5)
    *_, then, now = [world.step(Latest(CURVE, 0.1), Stamp(k * 100_000)).state for k in range(20)]
    way_m = math.hypot(now.x_m - then.x_m, now.y_m - then.y_m)
    assert way_m / 0.1 == pytest.approx(now.v_mps, rel=0.05), "the slip hardly changes within a frame"
    assert (now.yaw_rad - then.yaw_rad) / 0.1 == pytest.approx(now.omega_radps, rel=0.05)


def test_odometry_on_a_bus_measures_the_wheels(maps: Path) -> None:
    robot = Robot(map=maps / "empty.yaml", slip_ratio=0.25, odometry_jitter_s=0.0, state_hz=100.0, **PARAMS)
    robot.reset(3)
    ahead = Twist(v_mps=0.4, omega_radps=0.0)
    outputs = [robot.step(Latest(ahead, 0.0), Stamp(us)) for us in range(0, 3_000_001, 10_000)]
    read, state = outputs[-1].odometry, outputs[-1].state
    assert read is not None
    assert state is not None
    assert read.message.x_m == pytest.approx(0.4 * 2.9, abs=0.02)
    assert read.message.v_mps == pytest.approx(0.4)
    start = outputs[0].state
    assert start is not None
    driven_m = math.hypot(state.x_m - start.x_m, state.y_m - start.y_m)
    assert 0.5 * read.message.x_m < driven_m < 0.95 * read.message.x_m
    assert state.v_mps < 0.4


def test_the_same_seed_slips_the_same() -> None:
    steps = [{"command": Latest(CURVE, 0.1), "utime": Stamp(k * 100_000)} for k in range(12)]
    check_stage(Pymunk, *steps, map="maps/corridor_ccw.yaml", slip_ratio=0.2, size=(32, 24))
