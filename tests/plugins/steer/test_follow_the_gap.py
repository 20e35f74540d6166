"""Where it heads in scans that are made by hand."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from graphnav_steer.follow_the_gap import FollowTheGap

from graphnav import Goal, Latest, Scan

BEAMS = 541
STEP_RAD = 1.5 * math.pi / (BEAMS - 1)
ANGLES = -0.75 * math.pi + STEP_RAD * np.arange(BEAMS)
NONE: Latest[Any] = Latest()


def scan(*posts: tuple[float, float], range_m: float = math.inf) -> Scan:
    """Return a scan of posts at (forward, left), each in one beam; the others measure ``range_m``."""
    ranges = np.full(BEAMS, range_m, np.float32)
    for x, y in posts:
        ranges[round((math.atan2(y, x) + 0.75 * math.pi) / STEP_RAD)] = math.hypot(x, y)
    return Scan(-0.75 * math.pi, STEP_RAD, 0.1, 10.0, ranges)


def wall(*lefts: float, forward_m: float = 1.0) -> Sequence[tuple[float, float]]:
    """Return the posts of a wall across the way, with these distances to the left."""
    return [(forward_m, left) for left in lefts]


def theta_rad(scan: Scan, bearing_rad: float | None = None, **parameters: Any) -> float:
    stage = FollowTheGap(**({"robot_radius_m": 0.2, "margin_m": 0.0, "horizon_m": 2.0} | parameters))
    stage.reset(seed=0)
    goal = NONE if bearing_rad is None else Latest(Goal(bearing_rad=bearing_rad, distance_m=5.0), 0.0)
    return stage.step(scan, goal).theta_rad


@pytest.mark.parametrize("bearing_rad", [0.0, 0.7, -2.0])
def test_without_obstacles_it_heads_for_the_goal(bearing_rad: float) -> None:
    assert theta_rad(scan(), bearing_rad) == bearing_rad
    assert theta_rad(scan((3.0, 0.0)), bearing_rad) == bearing_rad


def test_the_heading_is_the_mean_of_the_papers_equation() -> None:
    # A gap between what is 1 m away on the right and 1.8 m on the left; grown, it is narrower.
    ranges = np.where(ANGLES < -0.7, 1.0, np.where(ANGLES > 0.9, 1.8, math.inf)).astype(np.float32)
    found = Scan(-0.75 * math.pi, STEP_RAD, 0.1, 10.0, ranges)
    first, last = -0.7 + math.asin(0.2 / 1.0), 0.9 - math.asin(0.2 / 1.8)
    middle = math.atan2(math.sin(first) + 1.8 * math.sin(last), math.cos(first) + 1.8 * math.cos(last))
    assert theta_rad(found) == pytest.approx(middle, abs=2 * STEP_RAD)
    weight = 1.5 / 1.0
    expected = (weight * middle + 0.3) / (weight + 1.0)
    assert theta_rad(found, 0.3, gap_weight_m=1.5) == pytest.approx(expected, abs=2 * STEP_RAD)


def test_a_gap_that_is_narrower_than_the_robot_is_none() -> None:
    posts = wall(*np.arange(-3.0, 3.0, 0.1), forward_m=0.6)
    closed = scan(*posts)
    assert abs(theta_rad(closed, 0.0, window_deg=120.0)) == pytest.approx(math.pi / 2)
    opened = scan(*[post for post in posts if not 0.2 < post[1] < 0.8])
    assert 0.2 < theta_rad(opened, window_deg=120.0) < 1.2


def test_with_no_cost_of_the_goal_the_widest_gap_is_chosen() -> None:
    ranges = np.full(BEAMS, 1.0, np.float32)
    ranges[(ANGLES > 0.4) & (ANGLES < 1.5)] = math.inf
    ranges[(ANGLES > -1.2) & (ANGLES < -0.3)] = math.inf
    found = Scan(-0.75 * math.pi, STEP_RAD, 0.1, 10.0, ranges)
    assert theta_rad(found, -0.7, goal_cost=0.0, gap_weight_m=1000.0) > 0.5
    assert theta_rad(found, -0.7, goal_cost=1.0, gap_weight_m=1000.0) < -0.5


def test_beams_that_tell_nothing_are_not_free() -> None:
    ranges = np.full(BEAMS, math.inf, np.float32)
    ranges[ANGLES > 0.0] = math.nan
    assert theta_rad(Scan(-0.75 * math.pi, STEP_RAD, 0.1, 10.0, ranges)) < -0.5


def test_where_there_is_no_gap_it_turns_to_the_side_that_it_turned_to() -> None:
    stage = FollowTheGap()
    stage.reset(seed=0)
    stage.step(scan(), Latest(Goal(bearing_rad=-0.5, distance_m=3.0), 0.0))
    assert stage.step(scan(range_m=0.3), NONE).theta_rad == -math.pi / 2


def test_beams_in_clockwise_order_are_the_same() -> None:
    one = scan((1.0, 0.3), (0.8, -0.6))
    other = Scan(0.75 * math.pi, -STEP_RAD, 0.1, 10.0, one.ranges_m[::-1])
    assert theta_rad(other, 0.2) == pytest.approx(theta_rad(one, 0.2), abs=1e-9)
