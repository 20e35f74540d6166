"""Which speeds the dynamic window approach chooses on maps that are drawn by hand."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from graphnav_steer.dwa import Dwa

from graphnav import Goal, Latest, LocalMap, Motion, Twist

DrawMap = Callable[..., LocalMap]
NONE: Latest[Any] = Latest()


def dwa(**parameters: Any) -> Dwa:
    stage = Dwa(**parameters)
    stage.reset(seed=0)
    return stage


def toward(bearing_rad: float, distance_m: float = 9.0) -> Latest[Goal]:
    return Latest(Goal(bearing_rad=bearing_rad, distance_m=distance_m), 0.0)


def moving(v_mps: float, omega_radps: float = 0.0, hz: float = 10.0) -> Latest[Motion]:
    motion = Motion(forward_m=v_mps / hz, left_m=0.0, turn_rad=omega_radps / hz, interval_us=round(1e6 / hz))
    return Latest(motion, 0.0)


def chosen(map: LocalMap, bearing_rad: float = 0.0, v_mps: float = 0.3, **parameters: Any) -> Twist:  # noqa: A002
    return dwa(**parameters).step(map, toward(bearing_rad), moving(v_mps)).twist


@pytest.mark.parametrize("yaw_rad", [0.0, 1.0, -2.5])
def test_free_floor_is_driven_straight_on_at_full_speed(draw_map: DrawMap, yaw_rad: float) -> None:
    found = chosen(draw_map(pose=(0.0, 0.0, yaw_rad)))
    assert found.v_mps == pytest.approx(0.3)
    assert found.omega_radps == pytest.approx(0.0, abs=0.1)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("bearing_rad", [0.8, 2.8])
def test_it_turns_to_where_the_goal_is(draw_map: DrawMap, side: float, bearing_rad: float) -> None:
    assert side * chosen(draw_map(), side * bearing_rad).omega_radps > 0.5


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_an_obstacle_ahead_is_passed_where_the_way_is_free(draw_map: DrawMap, side: float) -> None:
    found = chosen(draw_map(lambda x, y: np.hypot(x - 0.6, y - side * 0.12) < 0.15))
    assert side * found.omega_radps < -0.1
    assert found.v_mps > 0.0


def test_speeds_are_those_of_the_window(draw_map: DrawMap) -> None:
    stage = dwa(max_accel_mps2=0.5, max_turn_accel_radps2=2.0, period_s=0.1)
    found = stage.step(draw_map(), toward(0.5), moving(0.2, -0.4)).twist
    assert 0.15 - 1e-9 <= found.v_mps <= 0.25 + 1e-9
    assert -0.6 - 1e-9 <= found.omega_radps <= -0.2 + 1e-9


@pytest.mark.parametrize("hz", [5.0, 20.0])
def test_the_window_does_not_depend_on_the_time_between_two_frames(draw_map: DrawMap, hz: float) -> None:
    stage = dwa(max_speed_mps=1.0, max_accel_mps2=1.0, period_s=0.2)
    assert stage.step(draw_map(), toward(0.0), moving(0.2, hz=hz)).twist.v_mps == pytest.approx(0.4)


@pytest.mark.parametrize("what", ["obstacle", "unknown"])
def test_it_can_stop_before_what_is_ahead(draw_map: DrawMap, what: str) -> None:
    # 0.4 m of free way, up to a cell of 0.05 m, for a disc with its margin, or before the floor that was not seen.
    begins_m = 0.65 if what == "obstacle" else 0.4
    wall = draw_map(**{what: lambda x, _: x > begins_m})
    limits = {"max_speed_mps": 2.0, "max_accel_mps2": 20.0, "max_turn_radps": 0.01, "speed_samples": 81}
    found = chosen(wall, v_mps=1.0, **limits)
    assert 0.33 < found.v_mps * 0.25 + found.v_mps**2 / (2 * 0.5) <= 0.45


def test_unknown_floor_may_count_as_free(draw_map: DrawMap) -> None:
    found = chosen(draw_map(unknown=lambda x, _: x > 0.4), max_speed_mps=2.0, v_mps=1.9, unknown="free")
    assert found.v_mps == pytest.approx(2.0)


def test_a_robot_before_a_wall_turns_away_and_keeps_to_its_side(draw_map: DrawMap) -> None:
    stage = dwa()
    wall = draw_map(lambda x, _: x > 0.22)
    for bearing_rad in (0.3, -0.3):
        found = stage.step(wall, toward(bearing_rad), moving(0.0)).twist
        assert (found.v_mps, found.omega_radps) == (0.0, 1.2)


def test_a_robot_that_is_too_fast_brakes_and_keeps_its_direction(draw_map: DrawMap) -> None:
    found = chosen(draw_map(unknown=lambda x, _: x > 0.4), v_mps=1.0, max_speed_mps=1.0)
    assert found.v_mps == pytest.approx(0.5)
    assert found.omega_radps == pytest.approx(0.0, abs=0.1)


def test_a_disc_in_touch_may_leave_what_it_touches(draw_map: DrawMap) -> None:
    found = chosen(draw_map(lambda x, y: np.hypot(x + 0.15, y) < 0.06), v_mps=0.0)
    assert found.v_mps > 0.0


def test_without_goal_and_motion_it_sets_out_straight_on(draw_map: DrawMap) -> None:
    found = dwa().step(draw_map(), NONE, NONE).twist
    assert found.v_mps == pytest.approx(0.3)
    assert found.omega_radps == pytest.approx(0.0, abs=0.1)


def test_the_steering_is_the_direction_of_the_command(draw_map: DrawMap) -> None:
    found = dwa().step(draw_map(), toward(1.5), moving(0.2, 0.5))
    ratio = (found.twist.omega_radps / 1.2) / (found.twist.v_mps / 0.3)
    assert math.tan(found.steering.theta_rad) == pytest.approx(ratio)
