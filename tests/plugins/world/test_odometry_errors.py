"""Drift of the measured turn, and odometry that is late."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from graphnav_world.robot import Robot
from graphnav_world.world import Pymunk, WorldOutputs

from graphnav import Latest, Odometry, Stamp, Stamped, Twist

EXACT: dict[str, Any] = {"size": (32, 24), "odometry_scale_ratio": 0.0, "odometry_noise_ratio": 0.0}
REST = Twist(v_mps=0.0, omega_radps=0.0)
COMMANDS = [
    Twist(v_mps=float(v), omega_radps=float(w)) for v, w in np.random.default_rng(6).uniform([0, -1], [0.5, 1], (25, 2))
]


def drive(maps: Path, commands: list[Twist], seed: int = 3, **params: Any) -> list[WorldOutputs]:
    world = Pymunk(map=maps / "empty.yaml", **(EXACT | params))
    world.reset(seed)
    return [world.step(Latest(one, 0.1), Stamp(k * 100_000)) for k, one in enumerate(commands)]


def motions(outputs: list[WorldOutputs]) -> list[tuple[float, float, float, int]]:
    found = [out.motion for out in outputs if out.motion is not None]
    return [(one.forward_m, one.left_m, one.turn_rad, one.interval_us) for one in found]


def test_a_drift_turns_a_robot_that_stands_one_way_in_a_run(maps: Path) -> None:
    signs = set()
    for seed in range(8):
        turns = [turn for _, _, turn, _ in motions(drive(maps, [REST] * 6, seed, odometry_drift_degps=3.0))]
        assert turns == pytest.approx([turns[0]] * 5)
        assert abs(turns[0]) == pytest.approx(math.radians(3.0) * 0.1)
        signs.add(math.copysign(1.0, turns[0]))
    assert signs == {-1.0, 1.0}


def test_a_drift_adds_to_the_turn_and_leaves_the_drive_alone(maps: Path) -> None:
    plain, drifting = drive(maps, COMMANDS), drive(maps, COMMANDS, odometry_drift_degps=3.0)
    differences = np.array(motions(drifting)) - np.array(motions(plain))
    assert np.abs(differences[:, 2]) == pytest.approx(math.radians(3.0) * 0.1)
    assert not differences[:, [0, 1, 3]].any()
    assert [out.state.yaw_rad for out in plain] == [out.state.yaw_rad for out in drifting]


@pytest.mark.parametrize("frames", [1, 3, 10])
def test_motion_is_that_of_an_earlier_interval(frames: int, maps: Path) -> None:
    plain, late = drive(maps, COMMANDS), drive(maps, COMMANDS, odometry_delay_frames=frames)
    now, then = motions(late), motions(plain)
    assert now[:frames] == [(0.0, 0.0, 0.0, 100_000)] * frames
    assert now[frames:] == then[:-frames]
    assert [out.state.x_m for out in plain] == [out.state.x_m for out in late]


def samples(maps: Path, **params: Any) -> list[Stamped[Odometry]]:
    robot = Robot(map=maps / "empty.yaml", odometry_jitter_s=0.0, **(EXACT | params))
    robot.reset(3)
    found = []
    for us in range(0, 2_500_000, 10_000):
        command = COMMANDS[us // 100_000]
        found.append(robot.step(Latest(command, 0.01), Stamp(us)).odometry)
    return [one for one in found if one is not None]


@pytest.mark.parametrize("frames", [1, 3])
def test_on_a_bus_samples_are_late_by_image_periods(frames: int, maps: Path) -> None:
    plain, late = samples(maps), samples(maps, odometry_delay_frames=frames)
    lag = 5 * frames  # 50 samples and 10 images a second
    assert [one.utime for one in late] == [one.utime for one in plain]
    for then, now in zip(plain, late[lag:], strict=False):
        for field in ("x_m", "y_m", "yaw_rad", "v_mps", "omega_radps"):
            assert getattr(now.message, field) == pytest.approx(getattr(then.message, field), abs=1e-12)
    assert all(one.message.x_m == one.message.yaw_rad == 0.0 for one in late[:lag])


def test_on_a_bus_the_drift_accumulates_and_shows_in_the_rate(maps: Path) -> None:
    plain, drifting = samples(maps)[-1], samples(maps, odometry_drift_degps=3.0)[-1]
    turned = math.remainder(drifting.message.yaw_rad - plain.message.yaw_rad, 2 * math.pi)
    assert abs(turned) == pytest.approx(math.radians(3.0) * drifting.utime / 1e6)
    rate = drifting.message.omega_radps - plain.message.omega_radps
    assert rate == pytest.approx(math.copysign(math.radians(3.0), turned))
