"""Where the vector field histogram of maps that are drawn by hand leads to."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from graphnav_steer.vfh import Vfh

from graphnav import Goal, Latest, LocalMap, Motion, ParamError

DrawMap = Callable[..., LocalMap]
NONE: Latest[Any] = Latest()
SECTOR_RAD = 2 * math.pi / 72


def vfh(**parameters: Any) -> Vfh:
    stage = Vfh(**parameters)
    stage.reset(seed=0)
    return stage


def theta_rad(map: LocalMap, goal: Latest[Goal] = NONE, v_mps: float = 0.0) -> float:  # noqa: A002  # the port's name
    return vfh().step(map, goal, moving(v_mps)).theta_rad


def moving(v_mps: float) -> Latest[Motion]:
    return Latest(Motion(forward_m=v_mps / 10, left_m=0.0, turn_rad=0.0, interval_us=100_000), 0.0)


def toward(bearing_rad: float) -> Latest[Goal]:
    return Latest(Goal(bearing_rad=bearing_rad, distance_m=3.0), 0.0)


@pytest.mark.parametrize("bearing_rad", [0.0, 1.0, -2.5])
@pytest.mark.parametrize("yaw_rad", [0.0, 0.7])
def test_free_floor_is_driven_to_the_goal(draw_map: DrawMap, bearing_rad: float, yaw_rad: float) -> None:
    assert theta_rad(draw_map(pose=(0.0, 0.0, yaw_rad)), toward(bearing_rad)) == pytest.approx(bearing_rad)


@pytest.mark.parametrize("side", [1, -1])
def test_a_wall_ahead_is_left_to_the_side_that_is_open(draw_map: DrawMap, side: int) -> None:
    map_ = draw_map(lambda x, y: (x > 0.5) & (side * y < 0.3))
    # To the left or right of the wall's end by the robot's half width, and at most straight aside.
    assert SECTOR_RAD < side * theta_rad(map_) <= math.pi / 2 + SECTOR_RAD


def test_a_narrow_opening_is_entered_in_its_middle(draw_map: DrawMap) -> None:
    # Sides that a disc of 0.25 m passes between 0.15 and 0.45 m to the left, at 0.5 m.
    map_ = draw_map(lambda x, y: (np.abs(x - 0.5) < 0.03) & ((y < -0.1) | (y > 0.7)))
    assert theta_rad(map_, toward(0.0)) == pytest.approx(math.atan2(0.3, 0.5), abs=2 * SECTOR_RAD)


def test_without_an_opening_the_robot_turns_on_the_spot(draw_map: DrawMap) -> None:
    assert abs(theta_rad(draw_map(lambda x, y: np.hypot(x, y) > 0.3))) == math.pi / 2


def test_a_blocked_sector_is_free_again_below_the_lower_threshold_only(draw_map: DrawMap) -> None:
    def post(half_m: float) -> LocalMap:
        return draw_map(lambda x, y: (np.abs(x - 0.6) < half_m) & (np.abs(y) < half_m))

    # 9 cells, then 1, at 0.6 m: each has 0.64 of a cell at the robot's place.
    large, small = post(0.06), post(0.01)
    stage = vfh(max_density=2.0, min_density=0.5)
    assert stage.step(small, toward(0.0), NONE).theta_rad == 0.0
    assert abs(stage.step(large, toward(0.0), NONE).theta_rad) > 0.3
    assert abs(stage.step(small, toward(0.0), NONE).theta_rad) > 0.3
    assert stage.step(draw_map(), toward(0.0), NONE).theta_rad == 0.0
    assert stage.step(small, toward(0.0), NONE).theta_rad == 0.0


def test_what_the_turning_circle_meets_masks_the_floor_behind_it(draw_map: DrawMap) -> None:
    # The goal is to the left, behind a post that a robot at rest turns past, and one that drives does not.
    post = draw_map(lambda x, y: np.hypot(x - 0.25, y - 0.4) < 0.06)
    assert theta_rad(post, toward(2.4)) == pytest.approx(2.4, abs=2 * SECTOR_RAD)
    assert theta_rad(post, toward(2.4), v_mps=0.3) < 1.0


def test_the_cost_of_a_change_keeps_the_side(draw_map: DrawMap) -> None:
    wall = draw_map(lambda x, y: (np.abs(x - 0.6) < 0.1) & (np.abs(y) < 0.3))
    stage = vfh()
    left = stage.step(wall, toward(0.1), NONE).theta_rad
    assert left > 0.3
    # The goal seems a little to the right now: a robot that begins would pass there.
    assert stage.step(wall, toward(-0.05), NONE).theta_rad == pytest.approx(left)
    assert theta_rad(wall, toward(-0.05)) < -0.3


def test_obstacles_have_to_count_before_they_are_touched() -> None:
    with pytest.raises(ParamError, match=r"'active_m' is 0\.2, but radius and margin of the robot are 0\.25"):
        Vfh(active_m=0.2).check()


def test_a_sector_cannot_be_blocked_and_free() -> None:
    with pytest.raises(ParamError, match=r"'min_density' 3 is more than 'max_density' 2"):
        Vfh(min_density=3.0).check()
