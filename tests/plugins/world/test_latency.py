"""Commands act late, by exactly the latency."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from graphnav_world.drive import Drive
from graphnav_world.robot import Robot
from graphnav_world.vehicle import Limits, Vehicle
from graphnav_world.world import Pymunk

from graphnav import Latest, Stamp, Twist

QUICK: dict[str, Any] = {"speed_up_s": 1e-6, "turn_up_s": 1e-6, "max_speed_mps": 1.0, "size": (32, 24)}
AHEAD, STOP = Twist(v_mps=1.0, omega_radps=0.0), Twist(v_mps=0.0, omega_radps=0.0)


def way_m(world: Pymunk, ticks: int, stop_at: int) -> list[float]:
    """Return the way driven at every frame of 10 Hz; the command is to drive, and to stop from a frame on."""
    world.reset(3)
    places = []
    for k in range(ticks):
        command = AHEAD if k < stop_at else STOP
        state = world.step(Latest(command, 0.1), Stamp(k * 100_000)).state
        places.append((state.x_m, state.y_m))
    return [math.dist(place, places[0]) for place in places]


@pytest.mark.parametrize("latency_s", [0.0, 0.05, 0.1, 0.2, 0.237])
def test_the_way_is_that_without_latency_shifted_in_time(latency_s: float, maps: Path) -> None:
    way = way_m(Pymunk(map=maps / "empty.yaml", command_latency_s=latency_s, **QUICK), ticks=12, stop_at=6)
    for k, x_m in enumerate(way):
        expected_m = min(max(0.1 * k - latency_s, 0.0), 0.5)
        assert x_m == pytest.approx(expected_m, abs=1e-6), f"frame {k}"


def test_clearance_is_the_minimum_over_a_period_with_two_commands(tmp_path: Path) -> None:
    path = tmp_path / "map.yaml"
    path.write_text("start: {at_m: [0, 0]}\nobstacles: [{box: {center_m: [1, 0], size_m: [0.2, 2]}}]\n")
    world = Pymunk(map=path, command_latency_s=0.05, **QUICK)
    world.reset(0)
    forth, back = Twist(v_mps=1.0, omega_radps=0.0), Twist(v_mps=-1.0, omega_radps=0.0)
    states = [
        world.step(Latest(command, 0.1), Stamp(k * 100_000)).state
        for k, command in enumerate([STOP, forth, forth, back, back])
    ]
    assert states[3].clearance_m == pytest.approx(0.9 - 0.2 - 0.2, abs=1e-6), "in the middle of the period"
    assert states[3].x_m == pytest.approx(0.15, abs=1e-6)


@pytest.mark.parametrize("latency_s", [0.0, 0.05, 0.123])
def test_a_robot_on_a_bus_hears_and_forgets_commands_late(latency_s: float) -> None:
    limits = Limits(speed_mps=1.0, turn_radps=2.0, speed_up_s=1e-6, turn_up_s=1e-6)
    drive = Drive(Vehicle([], (0.0, 0.0, 0.0), 0.2, limits), timeout_s=0.5, latency_s=latency_s)
    drive.hear(Latest(AHEAD, 0.0), 0)
    for time_s in (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8):
        pose = drive.advance(round(1e6 * time_s))
        assert pose.x_m == pytest.approx(min(max(time_s - latency_s, 0.0), 0.5), abs=1e-6)


def test_both_worlds_have_the_same_latency(maps: Path) -> None:
    robot = Robot(map=maps / "empty.yaml", command_latency_s=0.15, state_hz=100.0, **QUICK)
    robot.reset(3)
    states = [robot.step(Latest(AHEAD, 0.0), Stamp(us)).state for us in range(0, 500_000, 10_000)]
    world = way_m(Pymunk(map=maps / "empty.yaml", command_latency_s=0.15, **QUICK), 5, 9)
    assert states[0] is not None
    for k, x_m in enumerate(world):
        state = states[10 * k]
        assert state is not None
        way = math.dist((state.x_m, state.y_m), (states[0].x_m, states[0].y_m))
        assert way == pytest.approx(x_m, abs=1e-6)
