"""Where the vector field histogram of maps that are drawn by hand leads to."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from graphnav_steer.vfh import Vfh

from graphnav import Goal, Latest, LocalMap, ParamError

DrawMap = Callable[..., LocalMap]
NONE: Latest[Any] = Latest()
SECTOR_RAD = 2 * math.pi / 72


def theta_rad(map: LocalMap, goal: Latest[Goal] = NONE) -> float:  # noqa: A002  # the port's name
    stage = Vfh()
    stage.reset(seed=0)
    return stage.step(map, goal).theta_rad


@pytest.mark.parametrize("bearing_rad", [0.0, 1.0, -2.5])
def test_free_floor_is_driven_to_the_goal(draw_map: DrawMap, bearing_rad: float) -> None:
    goal = Latest(Goal(bearing_rad=bearing_rad, distance_m=3.0), 0.0)
    assert theta_rad(draw_map(), goal) == pytest.approx(bearing_rad)


@pytest.mark.parametrize("side", [1, -1])
def test_a_wall_ahead_is_left_to_the_side_that_is_open(draw_map: DrawMap, side: int) -> None:
    map_ = draw_map(lambda x, y: (x > 0.5) & (side * y < 0.3))
    # To the left or right of the wall's end by the robot's half width, and at most straight aside.
    assert SECTOR_RAD < side * theta_rad(map_) <= math.pi / 2 + SECTOR_RAD


def test_without_a_valley_the_robot_turns_on_the_spot(draw_map: DrawMap) -> None:
    assert abs(theta_rad(draw_map(lambda x, y: np.hypot(x, y) > 0.3))) == math.pi / 2


def test_obstacles_have_to_count_before_they_are_touched() -> None:
    with pytest.raises(ParamError, match=r"'active_m' is 0\.2, but radius and margin of the robot are 0\.25"):
        Vfh(active_m=0.2).check()
