"""Which speeds are chosen on maps that are drawn by hand."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from graphnav_steer.rollout import Rollout

from graphnav import Goal, Latest, LocalMap, Motion, Twist

DrawMap = Callable[..., LocalMap]
NONE: Latest[Any] = Latest()


def rollout(**parameters: Any) -> Rollout:
    stage = Rollout(**parameters)
    stage.reset(seed=0)
    return stage


def toward(bearing_rad: float, distance_m: float = 9.0) -> Latest[Goal]:
    return Latest(Goal(bearing_rad=bearing_rad, distance_m=distance_m), 0.0)


def moving(v_mps: float, omega_radps: float = 0.0) -> Latest[Motion]:
    return Latest(Motion(forward_m=v_mps / 10, left_m=0.0, turn_rad=omega_radps / 10, interval_us=100_000), 0.0)


def chosen(map: LocalMap, bearing_rad: float = 0.0, **parameters: Any) -> Twist:  # noqa: A002
    return rollout(**parameters).step(map, toward(bearing_rad), moving(0.3))


@pytest.mark.parametrize("yaw_rad", [0.0, 1.0, -2.5])
def test_free_floor_is_driven_straight_on_at_full_speed(draw_map: DrawMap, yaw_rad: float) -> None:
    found = chosen(draw_map(pose=(0.0, 0.0, yaw_rad)))
    assert found.v_mps == 0.5
    assert abs(found.omega_radps) < 0.3


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_it_turns_to_where_the_goal_is(draw_map: DrawMap, side: float) -> None:
    found = chosen(draw_map(), side * 0.8)
    assert side * found.omega_radps > 0.2
    assert found.v_mps > 0.0


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_goal_behind_is_turned_to_on_the_spot(draw_map: DrawMap, side: float) -> None:
    stage = rollout()
    found = stage.step(draw_map(), toward(side * 2.9), moving(0.0))
    assert found.v_mps == 0.0
    assert abs(found.omega_radps) >= 0.314
    # It keeps to the side until it has driven, wherever the goal seems to be now.
    again = stage.step(draw_map(), toward(-side * 2.9), moving(0.0))
    assert again.omega_radps * found.omega_radps > 0.0


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_an_obstacle_ahead_is_passed_where_the_way_is_shorter(draw_map: DrawMap, side: float) -> None:
    found = chosen(draw_map(lambda x, y: np.hypot(x - 0.8, y - side * 0.1) < 0.2))
    assert side * found.omega_radps < -0.05


def test_the_path_leads_through_a_door_beside_the_goal_s_bearing(draw_map: DrawMap) -> None:
    found = chosen(draw_map(lambda x, y: (np.abs(x - 0.8) < 0.05) & ~((y > 0.4) & (y < 1.2))))
    assert found.omega_radps > 0.2


def test_speeds_are_those_of_the_window(draw_map: DrawMap) -> None:
    limits = {"max_accel_mps2": 1.0, "max_turn_accel_radps2": 2.0}
    found = rollout(**limits).step(draw_map(), toward(0.5), moving(0.2, -0.4))
    assert 0.1 <= found.v_mps <= 0.3 + 1e-9
    assert found.omega_radps == 0.0 or -0.6 - 1e-9 <= found.omega_radps <= -0.2 + 1e-9


def test_no_trajectory_touches(draw_map: DrawMap) -> None:
    # Along its arc the disc stays before a wall, up to a cell, although the goal is behind that.
    found = chosen(draw_map(lambda x, _: x > 0.7), robot_radius_m=0.2)
    yaw_rad = found.omega_radps * np.linspace(0.0, 2.0, 200)
    forward_m = np.cumsum(found.v_mps * np.cos(yaw_rad)) * 0.01
    assert 0.0 < forward_m.max() <= 0.55


def test_a_disc_in_touch_backs_up_until_it_has_left(draw_map: DrawMap) -> None:
    stage = rollout()
    around = draw_map(lambda x, y: (np.hypot(x - 0.15, y) < 0.06) | (np.abs(y) > 0.3) & (np.abs(y) < 0.4))
    found = stage.step(around, toward(0.0), moving(0.0))
    assert found.v_mps <= 0.0


def test_without_a_goal_it_goes_straight_on(draw_map: DrawMap) -> None:
    found = rollout().step(draw_map(), NONE, NONE)
    assert found.v_mps == 0.5
    assert abs(found.omega_radps) < 0.3


def test_a_robot_that_is_shut_in_turns(draw_map: DrawMap) -> None:
    found = rollout().step(draw_map(lambda x, y: np.hypot(x, y) > 0.32), toward(0.0), moving(0.0))
    assert found.v_mps == 0.0
    assert abs(found.omega_radps) > 0.3


def test_a_path_that_is_near_obstacles_costs(draw_map: DrawMap) -> None:
    # It comes less near to a post beside the way, more slowly or farther aside.
    post = draw_map(lambda x, y: np.hypot(x - 0.7, y - 0.32) < 0.08)
    near, blind = chosen(post, near_cost_m=5.0), chosen(post, near_cost_m=0.0)
    assert near.omega_radps <= blind.omega_radps
    assert near.v_mps <= blind.v_mps
    assert near != blind
