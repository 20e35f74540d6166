"""Which directions are chosen in pictures that are drawn by hand."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from graphnav_steer.picture_gap import PictureGap

from graphnav import Goal, Latest, ParamError, Plane

ROWS, COLS = 40, 60
NONE: Latest[Any] = Latest()
FOOT = 30
"""The row in which the robot stands."""


def picture_gap(**parameters: Any) -> PictureGap:
    stage = PictureGap(**({"foot_ratio": FOOT / ROWS, "width_ratio": 0.2, "min_way_ratio": 0.3} | parameters))
    stage.reset(seed=0)
    return stage


def plane(obstacle: Any = None, judged: Any = None) -> Plane:
    """Return a plane; ``obstacle`` and ``judged`` say of cells, forward and left of the robot, what they are."""
    row, col = np.mgrid[:ROWS, :COLS]
    forward, left = FOOT - row - 0.5, COLS / 2 - col - 0.5
    is_obstacle = np.zeros((ROWS, COLS), np.bool_) if obstacle is None else obstacle(forward, left)
    valid = np.ones((ROWS, COLS), np.uint8) if judged is None else judged(forward, left).astype(np.uint8)
    score = is_obstacle.astype(np.float32)
    return Plane(
        obstacle=(is_obstacle & (valid != 0)).astype(np.uint8), score=score, valid=valid, step_px=4, obstacle_ratio=0.0
    )


def theta_rad(seen: Plane, goal: Latest[Goal] = NONE, **parameters: Any) -> float:
    return picture_gap(**parameters).step(seen, goal).theta_rad


def toward(bearing_rad: float) -> Latest[Goal]:
    return Latest(Goal(bearing_rad=bearing_rad, distance_m=3.0), 0.0)


def test_free_floor_is_driven_straight_on() -> None:
    assert theta_rad(plane()) == 0.0


@pytest.mark.parametrize("side", [1, -1])
def test_it_passes_an_obstacle_on_the_free_side(side: int) -> None:
    seen = plane(lambda forward, left: (np.abs(forward - 15) < 5) & (side * left > -4))
    assert 0.2 < -side * theta_rad(seen) < 1.2


@pytest.mark.parametrize("side", [1, -1])
def test_a_goal_decides_between_equal_ways(side: int) -> None:
    seen = plane(lambda forward, left: (np.abs(forward - 20) < 4) & (np.abs(left) < 3))
    assert side * theta_rad(seen, toward(side * 0.5)) > 0.2


@pytest.mark.parametrize(("width", "fits"), [(16, True), (8, False)])
def test_a_gap_of_the_width_of_the_robot_is_taken(width: int, fits: bool) -> None:
    # The robot needs 0.2 of 60 columns: 12.
    seen = plane(lambda forward, left: ((forward > 10) & (np.abs(left) > width / 2)) | (np.abs(left) > 20))
    found = theta_rad(seen, min_way_ratio=0.6)
    assert abs(found) < 0.3 if fits else abs(found) == math.pi / 2


def test_floor_behind_a_wall_is_not_reached() -> None:
    seen = plane(lambda forward, _: np.abs(forward - 8) < 1.5)
    assert abs(theta_rad(seen, min_way_ratio=0.5)) == math.pi / 2


def test_it_turns_on_to_the_side_that_it_began_with() -> None:
    stage = picture_gap(min_way_ratio=0.6)
    walls = [plane(lambda forward, left, s=s: (forward > 5) | (s * left > 20)) for s in (1, -1, 1)]
    found = [stage.step(wall, NONE).theta_rad for wall in walls]
    assert abs(found[0]) == math.pi / 2
    assert len(set(found)) == 1


def test_cells_that_were_not_judged_count_as_obstacles_unless_told_otherwise() -> None:
    seen = plane(judged=lambda forward, left: (np.abs(forward - 15) > 4) | (np.abs(left) > 6))
    assert abs(theta_rad(seen)) > 0.2
    assert theta_rad(seen, unjudged="free") == 0.0


def test_it_leaves_an_obstacle_that_it_touches() -> None:
    seen = plane(lambda forward, left: (forward < 3) & (left > 2) & (left < 6))
    assert theta_rad(seen) == pytest.approx(0.0, abs=0.6)


@pytest.mark.parametrize("shape", [(1, 1), (2, 3), (8, 8)])
def test_small_pictures_are_no_error(shape: tuple[int, int]) -> None:
    free = Plane(
        obstacle=np.zeros(shape, np.uint8),
        score=np.zeros(shape, np.float32),
        valid=np.ones(shape, np.uint8),
        step_px=4,
        obstacle_ratio=0.0,
    )
    assert math.isfinite(theta_rad(free))


def test_a_way_that_cannot_be_in_the_picture_is_refused() -> None:
    stage = PictureGap(foot_ratio=0.3, min_way_ratio=0.3)
    with pytest.raises(ParamError, match=r"'min_way_ratio' 0.3 is not less than 'foot_ratio' 0.3"):
        stage.check()
