"""Which headings of maps that are drawn by hand are chosen."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from graphnav_steer.gap import Gap

from graphnav import Goal, Latest, LocalMap, ParamError

DrawMap = Callable[..., LocalMap]
NONE: Latest[Any] = Latest()
HALF_HEADING_RAD = math.pi / 72 + 1e-9


def gap(**parameters: Any) -> Gap:
    given = {
        "robot_radius_m": 0.2,
        "margin_m": 0.0,
        "max_way_m": 1.2,
        "min_way_m": 0.1,
        "turn_cost_m": 0.3,
        "change_cost_m": 0.3,
        "goal_cost_m": 1.5,
        "headings": 72,
    }
    stage = Gap(**(given | parameters))
    stage.reset(seed=0)
    return stage


def theta_rad(map: LocalMap, goal: Latest[Goal] = NONE, **parameters: Any) -> float:  # noqa: A002
    return gap(**parameters).step(map, goal).theta_rad


def toward(bearing_rad: float) -> Latest[Goal]:
    return Latest(Goal(bearing_rad=bearing_rad, distance_m=3.0), 0.0)


def around(x: Any, y: Any) -> Any:
    """Say where a circular room of 0.5 m is bounded."""
    return np.hypot(x, y) > 0.5


@pytest.mark.parametrize("yaw_rad", [0.0, 1.0, -2.5])
def test_free_floor_is_driven_straight_on(draw_map: DrawMap, yaw_rad: float) -> None:
    assert theta_rad(draw_map(pose=(0.0, 0.0, yaw_rad))) == 0.0


@pytest.mark.parametrize("bearing_rad", [1.2, -1.2, 2.5, -2.5, 0.0])
def test_a_way_out_is_taken_where_it_is(draw_map: DrawMap, bearing_rad: float) -> None:
    def is_way(x: Any, y: Any) -> Any:
        c, s = math.cos(bearing_rad), math.sin(bearing_rad)
        return (c * x + s * y > 0) & (np.abs(c * y - s * x) < 0.35)

    # The way of 0.7 m leaves the disc 0.15 m to each side at 1.2 m: 0.13 rad.
    assert theta_rad(draw_map(lambda x, y: around(x, y) & ~is_way(x, y))) == pytest.approx(bearing_rad, abs=0.25)


@pytest.mark.parametrize(("cells", "fits"), [(5, False), (7, False), (9, True), (13, True)])
def test_a_gap_of_more_than_the_robot_is_taken(draw_map: DrawMap, cells: int, fits: bool) -> None:
    map_ = draw_map(lambda x, y: around(x, y) & ~((np.abs(y) < cells * 0.05 / 2) & (x > 0)))
    found = theta_rad(map_, min_way_m=0.5, turn_cost_m=0.6)
    # Turning further than the gap's slack of 0.1 m at 0.5 m does not lengthen the way.
    assert abs(found) < 0.2 if fits else abs(found) == math.pi / 2


@pytest.mark.parametrize("unknown", ["obstacle", "free"])
def test_unknown_floor_counts_as_it_is_told(draw_map: DrawMap, unknown: str) -> None:
    map_ = draw_map(unknown=lambda x, y: (x > 0.3) & (np.abs(y) < 1.0))
    found = theta_rad(map_, unknown=unknown)
    assert found == 0.0 if unknown == "free" else abs(found) > 0.8


@pytest.mark.parametrize("bearing_rad", [-2.0, -0.5, 0.0, 1.0, 3.0])
def test_free_floor_is_driven_to_the_goal(draw_map: DrawMap, bearing_rad: float) -> None:
    found = theta_rad(draw_map(), toward(bearing_rad), turn_cost_m=0.0)
    assert found == pytest.approx(bearing_rad, abs=HALF_HEADING_RAD)


def test_the_first_choice_is_kept_while_the_robot_turns(draw_map: DrawMap) -> None:
    def walls(x: Any, y: Any) -> Any:
        return np.abs(x) > 0.35

    stage = gap(change_cost_m=1.0, turn_cost_m=0.1)
    first = stage.step(draw_map(walls, pose=(0.0, 0.0, 0.2)), NONE).theta_rad
    # To the left by less than a right angle; later the other end of the corridor is nearer.
    assert first > 0
    later = stage.step(draw_map(walls, pose=(0.0, 0.0, -0.2)), NONE).theta_rad
    assert later == pytest.approx(first + 0.4, abs=0.3)


def test_a_robot_that_is_shut_in_turns_on_the_spot_to_one_side(draw_map: DrawMap) -> None:
    stage = gap()
    found = {
        stage.step(draw_map(lambda x, y: np.hypot(x, y) > 0.24, pose=(0.0, 0.0, yaw)), NONE).theta_rad
        for yaw in (0.0, 0.5, 1.0, 2.0)
    }
    assert len(found) == 1
    assert abs(found.pop()) == math.pi / 2


def test_the_same_maps_give_the_same_steering(draw_map: DrawMap) -> None:
    maps = [draw_map(around, pose=(0.02 * k, 0.0, 0.3 * k)) for k in range(6)]
    one, other = ([stage.step(map_, NONE).theta_rad for map_ in maps] for stage in (gap(), gap()))
    assert one == other


def test_a_way_longer_than_any_that_counts_cannot_be_asked_for() -> None:
    with pytest.raises(ParamError, match="'min_way_m' 2 is more than 'max_way_m' 1: the robot would only turn"):
        gap(max_way_m=1.0, min_way_m=2.0).check()
