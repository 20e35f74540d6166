"""The limits that a simulated base declares are those that it keeps."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from graphnav_world.lidar import Lidar
from graphnav_world.mobile_robot import MobileRobot
from graphnav_world.robot import Robot
from graphnav_world.world import Pymunk

from graphnav import BaseLimits, Latest, Stamp, State, Twist

STEP_US = 10_000
"""That of the physics: speeds change at each."""
SMALL: dict[str, Any] = {"size": (32, 24), "rate_hz": 100.0}
BASES: dict[str, dict[str, Any]] = {
    "as by default": {},
    "strong": {"max_speed_mps": 2.0, "speed_up_s": 0.2},
    "weak": {"max_speed_mps": 0.5, "speed_up_s": 1.6},
    "late": {"command_latency_s": 0.15},
    "late and weak": {"command_latency_s": 0.237, "speed_up_s": 0.9, "turn_up_s": 0.7, "max_turn_radps": 1.1},
    "slipping": {"slip_ratio": 0.3, "slip_correlation_s": 0.2, "command_latency_s": 0.05},
}
STOP_US = 3_000_000


@pytest.fixture(params=[Pymunk, Lidar, Robot])
def world(request: pytest.FixtureRequest) -> type[MobileRobot]:
    chosen: type[MobileRobot] = request.param
    return chosen


def drive(
    world: type[MobileRobot], twist: Twist, maps: Path, base: dict[str, Any]
) -> tuple[list[BaseLimits], list[State]]:
    """Drive by a command and stop after 3 s; return what was declared, and the state at every step of 7 s."""
    robot = world(map=maps / "empty.yaml", **SMALL, **base)
    if isinstance(robot, Robot):
        robot.state_hz = 100.0
    robot.reset(3)
    declared: list[BaseLimits] = []
    states: list[State] = []
    for utime in range(0, 7_000_000, STEP_US):
        command = twist if utime < STOP_US else Twist(v_mps=0.0, omega_radps=0.0)
        outputs: Any = robot.step(Latest(command, 0.0), Stamp(utime))  # type: ignore[attr-defined]
        states.append(outputs.state)
        if outputs.limits is not None:
            declared.append(outputs.limits)
    return declared, states


@pytest.mark.parametrize("base", BASES.values(), ids=BASES)
def test_it_stops_within_the_declared_way(world: type[MobileRobot], maps: Path, base: dict[str, Any]) -> None:
    declared, states = drive(world, Twist(v_mps=9.0, omega_radps=0.0), maps, base)
    limits = declared[0]
    at = STOP_US // STEP_US
    fastest_mps = max(state.v_mps for state in states)
    assert fastest_mps <= limits.max_speed_mps + 1e-9
    way_m = math.dist((states[at].x_m, states[at].y_m), (states[-1].x_m, states[-1].y_m))
    stopping_m = limits.max_speed_mps * limits.latency_s + limits.max_speed_mps**2 / (2 * limits.max_decel_mps2)
    # Speeds change in steps: what is left of the way is at most a step of the physics at full speed.
    one_step_m = limits.max_speed_mps * STEP_US * 1e-6
    assert way_m <= stopping_m + one_step_m
    if "slip_ratio" not in base:
        assert way_m >= stopping_m - 2 * one_step_m, "no braking is withheld"
        assert fastest_mps == pytest.approx(limits.max_speed_mps)


@pytest.mark.parametrize("base", BASES.values(), ids=BASES)
def test_it_speeds_up_and_turns_no_faster_than_declared(
    world: type[MobileRobot], maps: Path, base: dict[str, Any]
) -> None:
    declared, states = drive(world, Twist(v_mps=0.0, omega_radps=9.0), maps, base)
    turns = [state.omega_radps for state in states]
    limits = declared[0]
    assert max(turns) <= limits.max_turn_radps + 1e-9
    if "slip_ratio" not in base:
        fastest = max(abs(b - a) for a, b in pairwise(turns)) / (STEP_US * 1e-6)
        assert fastest == pytest.approx(limits.max_turn_accel_radps2)
        _, states = drive(world, Twist(v_mps=9.0, omega_radps=0.0), maps, base)
        gains = [b.v_mps - a.v_mps for a, b in pairwise(states)]
        assert max(gains) / (STEP_US * 1e-6) == pytest.approx(limits.max_accel_mps2)
        assert -min(gains) / (STEP_US * 1e-6) == pytest.approx(limits.max_decel_mps2)


def test_it_declares_them_once_and_a_robot_on_a_bus_again_for_late_subscribers(
    world: type[MobileRobot], maps: Path
) -> None:
    declared, _ = drive(world, Twist(v_mps=0.1, omega_radps=0.0), maps, {})
    assert len(declared) == (4 if world is Robot else 1)
