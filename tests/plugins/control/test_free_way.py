"""How far the way ahead is free, and that no command is faster than the robot can stop within it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from graphnav_control.nonholonomic import Nonholonomic, free_way_m, safe_speed_mps
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from graphnav import Latest, LocalMap, Stamp, Steering, Twist

DrawMap = Callable[..., LocalMap]
CELL_M, RADIUS_M = 0.05, 0.2
angles_rad = st.floats(-math.pi, math.pi)


def asked(theta_rad: float) -> Steering:
    force = np.array([-math.sin(theta_rad), math.cos(theta_rad)])
    return Steering(repulsive=np.zeros(2), guiding=force, control=force, theta_rad=theta_rad, eigenvalues=np.zeros(2))


def control(**parameters: Any) -> Nonholonomic:
    stage = Nonholonomic(**({"max_speed_mps": 0.4, "robot_radius_m": RADIUS_M, "map_error_m": 0.0} | parameters))
    stage.reset(seed=0)
    return stage


def speeds(twist: Twist) -> tuple[float, float]:
    return twist.v_mps, twist.omega_radps


def stopping_m(speed_mps: float, stage: Nonholonomic) -> float:
    """Return how far the robot drives until it stands."""
    assert stage.reaction_s is not None
    assert stage.max_decel_mps2 is not None
    return abs(speed_mps) * stage.reaction_s + speed_mps**2 / (2 * stage.max_decel_mps2)


@pytest.mark.parametrize("wall_m", [0.4, 0.73, 1.2])
@pytest.mark.parametrize("yaw_rad", [0.0, 0.6, -2.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_way_to_a_wall(draw_map: DrawMap, wall_m: float, yaw_rad: float, sign: float) -> None:
    c, s = sign * math.cos(yaw_rad), sign * math.sin(yaw_rad)
    map_ = draw_map(lambda x, y: c * x + s * y > wall_m, pose=(0.0, 0.0, yaw_rad))
    # The wall is made of cells, and the way of steps of half a cell.
    assert free_way_m(map_, RADIUS_M, sign) == pytest.approx(wall_m - RADIUS_M, abs=1.5 * CELL_M)


def test_what_is_beside_the_way_does_not_end_it(draw_map: DrawMap) -> None:
    # Two cells of room at each side.
    map_ = draw_map(lambda _, y: np.abs(y) > RADIUS_M + 2 * CELL_M)
    assert free_way_m(map_, RADIUS_M) > 1.9
    assert free_way_m(map_, RADIUS_M + 4 * CELL_M, 1.0) > 1.9, "in touch already; nothing comes nearer"


def test_unknown_floor_ends_the_way_where_it_begins(draw_map: DrawMap) -> None:
    map_ = draw_map(unknown=lambda x, _: x > 0.8)
    assert free_way_m(map_, RADIUS_M) == pytest.approx(0.8, abs=1.5 * CELL_M)


def test_in_touch_the_robot_may_leave_but_not_press_on(draw_map: DrawMap) -> None:
    map_ = draw_map(lambda x, _: x > 0.1)
    assert free_way_m(map_, RADIUS_M, 1.0) <= CELL_M / 2
    assert free_way_m(map_, RADIUS_M, -1.0) > 1.0


@example(way_m=0.0, decel=1.0, reaction_s=2.2250738585e-313)
@given(way_m=st.floats(0, 20), decel=st.floats(0.05, 5), reaction_s=st.floats(0, 2))
def test_the_safe_speed_is_the_fastest_that_stops_in_time(way_m: float, decel: float, reaction_s: float) -> None:
    speed_mps = safe_speed_mps(way_m, decel, reaction_s)
    assert speed_mps >= 0.0
    # The difference of a root and a number below 10 keeps about 1e-15 of it.
    assert speed_mps * reaction_s + speed_mps**2 / (2 * decel) == pytest.approx(way_m, rel=1e-6, abs=1e-6)


@settings(max_examples=60, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    theta_rad=angles_rad,
    wall_m=st.floats(-0.1, 1.8),
    sign=st.sampled_from([1.0, -1.0]),
    decel=st.floats(0.1, 2.0),
    reaction_s=st.floats(0.0, 1.0).map(lambda x: round(x, 6)),
    smoothing_s=st.sampled_from([0.0, 0.5]),
    law=st.sampled_from([{}, {"reversing": True}, {"floor_ratio": 0.5}]),
)
def test_no_command_is_too_fast_to_stop_within_the_way(
    draw_map: DrawMap,
    theta_rad: float,
    wall_m: float,
    sign: float,
    decel: float,
    reaction_s: float,
    smoothing_s: float,
    law: dict[str, Any],
) -> None:
    stage = control(max_decel_mps2=decel, reaction_s=reaction_s, smoothing_s=smoothing_s, **law)
    stage.step(asked(0.0), Latest(), Stamp(0))
    map_ = draw_map(lambda x, _: sign * x > wall_m + RADIUS_M)
    twist = stage.step(asked(theta_rad), Latest(map_, 0.0), Stamp(100_000))
    drives_there = twist.v_mps * sign > 0
    if drives_there:
        assert stopping_m(twist.v_mps, stage) <= max(wall_m, 0.0) + 1.5 * CELL_M
    without = control(max_decel_mps2=decel, reaction_s=reaction_s, smoothing_s=smoothing_s, **law)
    without.step(asked(0.0), Latest(), Stamp(0))
    free = without.step(asked(theta_rad), Latest(), Stamp(100_000))
    assert abs(twist.v_mps) <= abs(free.v_mps)
    assert twist.omega_radps == free.omega_radps


def test_a_robot_that_drives_at_a_wall_comes_to_a_stop_before_it(draw_map: DrawMap) -> None:
    stage = control(max_decel_mps2=0.5, reaction_s=0.3)
    x_m, speeds = -1.0, []
    for tick in range(200):
        map_ = draw_map(lambda x, _: x > 0.825, pose=(x_m, 0.0, 0.0))
        speeds.append(stage.step(asked(0.0), Latest(map_, 0.0), Stamp(100_000 * tick)).v_mps)
        x_m += 0.1 * speeds[-1]
    assert speeds[0] == 0.4
    assert speeds[-1] == 0.0
    assert (np.diff(speeds) <= 0).all()
    # The wall's cells begin at 0.825; the way ends within a step and the reaction's.
    assert 0.825 - RADIUS_M - 2 * CELL_M < x_m < 0.825 - RADIUS_M + CELL_M / 2


def test_a_narrow_way_is_taken_where_the_steering_leads_through_it(draw_map: DrawMap) -> None:
    # The map shows a door that is 5 cm too narrow to each side.
    door = draw_map(lambda x, y: (np.abs(x - 0.25) < 0.1) & (np.abs(y) > RADIUS_M - 0.05))
    assert control(map_error_m=0.1).step(asked(0.0), Latest(door, 0.0), Stamp(0)).v_mps > 0.2
    assert control(map_error_m=0.0).step(asked(0.0), Latest(door, 0.0), Stamp(0)).v_mps < 0.1


def test_a_robot_that_is_steered_past_a_corner_does_not_cut_it(draw_map: DrawMap) -> None:
    # A corner ahead at the right; the steering leads past it at the left, the robot has not turned yet.
    map_ = draw_map(lambda x, y: (x > 0.2) & (y < 0.05))
    past = control(map_error_m=0.1).step(asked(0.9), Latest(map_, 0.0), Stamp(0))
    free = control().step(asked(0.9), Latest(), Stamp(0))
    assert past.v_mps < 0.6 * free.v_mps
    assert past.omega_radps == free.omega_radps


def test_a_free_map_does_not_limit(draw_map: DrawMap) -> None:
    for theta_rad in (-2.0, -0.4, 0.0, 1.0):
        free = Latest(draw_map(half_m=3.0), 0.0)
        stage = control(max_decel_mps2=0.5, reaction_s=0.2)
        limited = stage.step(asked(theta_rad), free, Stamp(0))
        assert speeds(limited) == speeds(control().step(asked(theta_rad), Latest(), Stamp(0)))


@given(theta_rad=angles_rad, floor_ratio=st.floats(0, 1).map(lambda x: round(x, 6)))
def test_without_a_map_the_law_is_unchanged_to_the_last_bit(theta_rad: float, floor_ratio: float) -> None:
    omega = math.sin(theta_rad) if abs(theta_rad) <= math.pi / 2 else math.copysign(1.0, theta_rad)
    twist = control(max_turn_radps=1.3, floor_ratio=floor_ratio).step(asked(theta_rad), Latest(), Stamp(0))
    assert speeds(twist) == (0.4 * max(math.cos(theta_rad), floor_ratio), 1.3 * omega)
    reversing = control(max_turn_radps=1.3, reversing=True).step(asked(theta_rad), Latest(), Stamp(0))
    assert speeds(reversing) == (0.4 * math.cos(theta_rad), 1.3 * math.sin(theta_rad))
