"""Where the frontiers of maps that are drawn by hand lead to."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from graphnav_steer.frontier import Frontier

from graphnav import Goal, Latest, LocalMap, RecoveryState, Steering

DrawMap = Callable[..., LocalMap]
NONE: Latest[Any] = Latest()
RADIUS_M = 0.2


def frontier(**parameters: Any) -> Frontier:
    given = {
        "robot_radius_m": RADIUS_M,
        "margin_m": 0.05,
        "map_error_m": 0.0,
        "squeeze_m": 0.0,
        "unknown_margin_m": 0.05,
        "narrow_cost": 1.0,
        "min_frontier_m2": 0.1,
        "comfort_m": 0.25,
        "near_cost": 1.0,
        "look_ahead_m": 0.6,
        "turn_cost_m": 1.0,
        "back_cost_m": 2.0,
        "commit_m": 0.3,
        "goal_weight": 1.5,
    }
    stage = Frontier(**(given | parameters))
    stage.reset(seed=0)
    return stage


def theta_rad(map: LocalMap, goal: Latest[Goal] = NONE, **parameters: Any) -> float:  # noqa: A002
    return frontier(**parameters).step(map, goal).theta_rad


def toward(bearing_rad: float, distance_m: float = 3.0) -> Latest[Goal]:
    return Latest(Goal(bearing_rad=bearing_rad, distance_m=distance_m), 0.0)


def room(x: Any, y: Any) -> Any:
    """Say where the walls of a square room of 1.8 m are, and what is behind them."""
    return np.maximum(np.abs(x), np.abs(y)) > 0.9


def corridor(x: Any, y: Any) -> Any:
    return np.abs(y) > 0.5


def test_a_free_corridor_leads_straight_on(draw_map: DrawMap) -> None:
    map_ = draw_map(corridor, lambda x, y: (np.abs(x) > 1.2) & (np.abs(y) <= 0.5))
    # The frontier is a few cells wide; its cheapest cell is at most one row from the middle of the corridor.
    assert abs(theta_rad(map_)) < 0.1


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("yaw_rad", [0.0, 2.0])
def test_a_wall_with_an_opening_at_one_side_is_left_there(draw_map: DrawMap, side: int, yaw_rad: float) -> None:
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)

    def is_opening(x: Any, y: Any) -> Any:
        ahead, left = c * x + s * y, c * y - s * x
        return (np.abs(ahead) < 0.5) & (side * left > 0.0)

    map_ = draw_map(
        lambda x, y: (np.hypot(x, y) > 0.9) & ~is_opening(x, y),
        lambda x, y: (np.hypot(x, y) > 1.3) & is_opening(x, y),
        (0.0, 0.0, yaw_rad),
    )
    assert side * theta_rad(map_) == pytest.approx(math.pi / 2, abs=0.4)


def test_a_dead_end_is_left_by_turning_back(draw_map: DrawMap) -> None:
    map_ = draw_map(lambda x, y: corridor(x, y) | (x > 0.6), lambda x, y: (x < -1.3) & (np.abs(y) <= 0.5))
    assert abs(theta_rad(map_)) == math.pi / 2
    behind = draw_map(
        lambda x, y: corridor(x, y) | (x > 0.6), lambda x, y: (x < -1.3) & (np.abs(y) <= 0.5), (0.0, 0.0, math.pi)
    )
    assert abs(theta_rad(behind)) < 0.2


@pytest.mark.parametrize(("cells", "fits"), [(5, False), (7, False), (9, True), (13, True)])
@pytest.mark.parametrize("aside_cells", [-4, 0, 4])
def test_a_gap_of_more_than_the_robot_is_taken(draw_map: DrawMap, cells: int, fits: bool, aside_cells: int) -> None:
    def is_gap(x: Any, y: Any) -> Any:
        return (x > 0) & (np.abs(y - 0.05 * aside_cells) < cells * 0.05 / 2)

    map_ = draw_map(lambda x, y: room(x, y) & ~((x < 1.1) & is_gap(x, y)) & (x < 1.1), lambda x, y: x > 1.4)
    found = theta_rad(map_)
    if fits:
        # The heading is that of a point up to 0.6 m ahead on the way to a gap 0.9 m ahead.
        assert found == pytest.approx(math.atan2(0.05 * aside_cells, 0.9), abs=0.3)
    else:
        assert abs(found) == math.pi / 2


def test_a_robot_that_is_shut_in_turns_on_the_spot_to_one_side(draw_map: DrawMap) -> None:
    stage = frontier()
    found = [stage.step(draw_map(room, pose=(0.0, 0.0, yaw)), NONE).theta_rad for yaw in (0.0, 0.5, 1.0)]
    assert {abs(theta) for theta in found} == {math.pi / 2}
    assert len(set(found)) == 1


@pytest.mark.parametrize("side", [1, -1])
def test_the_door_beside_the_goal_s_direction_is_taken(draw_map: DrawMap, side: int) -> None:
    def is_wall(x: Any, y: Any) -> Any:
        return (np.abs(x - 0.75) < 0.1) & (np.abs(side * y - 1.0) > 0.35)

    map_ = draw_map(lambda x, y: is_wall(x, y) | (np.maximum(-x, np.abs(y)) > 1.7), lambda x, y: x > 1.2)
    # A beacon straight ahead; the door's middle is 53 degrees aside, and the way there keeps away from the wall.
    assert 0.4 < side * theta_rad(map_, toward(0.0)) < math.pi / 2 + 0.1


@pytest.mark.parametrize("side", [1, -1])
def test_of_two_ways_the_one_to_the_goal_is_taken(draw_map: DrawMap, side: int) -> None:
    map_ = draw_map(lambda x, y: np.abs(x) > 0.5, lambda x, y: (np.abs(y) > 1.0) & (np.abs(x) <= 0.5), (0.0, 0.0, 0.0))
    assert side * theta_rad(map_, toward(side * 1.2)) == pytest.approx(math.pi / 2, abs=0.2)
    # The robot's frame turns, the map's does not.
    turned = draw_map(
        lambda x, y: np.abs(x) > 0.5, lambda x, y: (np.abs(y) > 1.0) & (np.abs(x) <= 0.5), (0.0, 0.0, 0.7)
    )
    expected = max(side * math.pi / 2 - 0.7, -math.pi / 2)
    assert theta_rad(turned, toward(side * math.pi / 2 - 0.7)) == pytest.approx(expected, abs=0.2)


def test_without_a_goal_the_way_not_yet_driven_is_taken(draw_map: DrawMap) -> None:
    def unknown(x: Any, y: Any) -> Any:
        return (np.abs(x) > 1.6) & (np.abs(y) <= 0.5)

    stage = frontier(turn_cost_m=0.0, back_cost_m=5.0, commit_m=0.0)
    for x_m in np.linspace(-1.4, 0.0, 15):
        stage.step(draw_map(corridor, unknown, (x_m, 0.0, 0.0)), NONE)
    assert abs(stage.step(draw_map(corridor, unknown, (-0.3, 0.0, math.pi / 2)), NONE).theta_rad + math.pi / 2) < 0.3


def test_a_choice_is_kept_until_another_one_is_cheaper(draw_map: DrawMap) -> None:
    def unknown(x: Any, y: Any) -> Any:
        return (np.abs(y) > 1.0) & (np.abs(x) <= 0.5)

    def first_and_second(commit_m: float) -> tuple[float, float]:
        stage = frontier(commit_m=commit_m, turn_cost_m=0.0, back_cost_m=0.0)
        maps = [draw_map(lambda x, _: np.abs(x) > 0.5, unknown, (0.0, y_m, 0.0)) for y_m in (0.1, -0.1)]
        first, second = (stage.step(map_, NONE).theta_rad for map_ in maps)
        return first, second

    first, second = first_and_second(0.0)
    assert first > 0 > second
    first, second = first_and_second(1.0)
    assert first > 0
    assert second > 0


def test_a_frontier_of_little_floor_is_not_worth_a_visit(draw_map: DrawMap) -> None:
    def unknown(x: Any, y: Any) -> Any:
        return np.hypot(x - 0.6, y) < 0.13

    map_ = draw_map(room, unknown)
    # Its rim is seen under 0.27 rad.
    assert abs(theta_rad(map_, min_frontier_m2=0.01)) < 0.35
    assert abs(theta_rad(map_, min_frontier_m2=0.3)) == math.pi / 2


def test_from_another_way_on_a_frontier_of_any_size_is_taken_where_there_is_no_other(draw_map: DrawMap) -> None:
    def small(x: Any, y: Any) -> Any:
        return np.hypot(x - 0.6, y) < 0.13

    def doing(what: str) -> Latest[RecoveryState]:
        return Latest(RecoveryState(doing=what, recoveries=1, turned_rad=0.0, doubt=8.0), 0.1)

    stage = frontier(min_frontier_m2=0.3)
    shut_in, wide = draw_map(room, small), draw_map(lambda x, y: x < -0.9, lambda x, y: small(x, y) | (y > 1.2))
    found = [stage.step(shut_in, NONE, doing(what)).theta_rad for what in ("", "look_again", "other_way", "")]
    assert [abs(theta) == math.pi / 2 for theta in found] == [True, True, False, False]
    assert abs(found[-1]) < 0.35
    assert stage.step(wide, NONE, doing("")).theta_rad == theta_rad(wide, min_frontier_m2=0.3)


def test_touching_a_wall_the_robot_gets_away(draw_map: DrawMap) -> None:
    def unknown(x: Any, y: Any) -> Any:
        return (np.abs(x) > 1.2) & (np.abs(y) <= 0.5)

    yaws_rad = (0.0, -0.6, -1.2)
    found = [theta_rad(draw_map(lambda _, y: np.abs(y) > 0.5, unknown, (0.0, 0.4, yaw))) for yaw in yaws_rad]
    for yaw_rad, theta in zip(yaws_rad, found, strict=True):
        assert -math.pi < yaw_rad + theta < 0.05
    assert len(set(found)) == len(found), "it does not turn because it is shut in"


def test_it_squeezes_through_a_narrow_gap_if_there_is_hardly_another_way(draw_map: DrawMap) -> None:
    def is_wall(x: Any, y: Any) -> Any:
        return (np.abs(x - 0.75) < 0.06) & (np.abs(y) > 0.175)

    shut = draw_map(lambda x, y: is_wall(x, y) | (np.maximum(-x, np.abs(y)) > 1.4), lambda x, y: x > 1.2)
    assert abs(theta_rad(shut, toward(0.0))) == math.pi / 2
    assert abs(theta_rad(shut, toward(0.0), squeeze_m=0.06)) < 0.1

    def is_aside(x: Any, y: Any) -> Any:
        return (y > 1.0) & (np.abs(x) < 0.6)

    # Another way, to the left, that is longer by less than what squeezing costs.
    either = draw_map(
        lambda x, y: is_wall(x, y) | (np.maximum(-x, np.abs(y)) > 1.4), lambda x, y: (x > 1.2) | is_aside(x, y)
    )
    assert theta_rad(either, toward(0.3), squeeze_m=0.06) > 0.5


@pytest.mark.parametrize(("at_m", "straight_back"), [(0.1, True), (-0.1, False)])
def test_it_gives_way_to_what_moves_straight_on_or_back(draw_map: DrawMap, at_m: float, straight_back: bool) -> None:
    def moving(x: Any, y: Any) -> Any:
        return (np.abs(x - at_m) < 0.15) & (y > -1.0)

    map_ = draw_map(corridor, lambda x, y: (np.abs(x) > 1.2) & (np.abs(y) <= 0.5), moving=moving)
    found = theta_rad(map_)
    assert found == (math.pi if straight_back else 0.0)
    assert abs(theta_rad(map_, give_way_m=0.0)) <= math.pi / 2
    standing = draw_map(lambda x, y: corridor(x, y) | moving(x, y), lambda x, y: (np.abs(x) > 1.2) & (np.abs(y) <= 0.5))
    assert theta_rad(standing) != math.pi, "it gives way only to what moves"


def test_it_does_not_give_way_over_unknown_floor(draw_map: DrawMap) -> None:
    def moving(x: Any, _: Any) -> Any:
        return (x > -0.05) & (x < 0.5)

    behind = draw_map(unknown=lambda x, _: x < -0.1, moving=moving)
    assert abs(theta_rad(behind)) <= math.pi / 2


def test_the_force_points_along_the_angle(draw_map: DrawMap) -> None:
    steering: Steering = frontier().step(draw_map(corridor, lambda x, _: np.abs(x) > 1.2), toward(0.3))
    x, y = steering.control
    assert math.hypot(x, y) == pytest.approx(1.0)
    assert math.atan2(-x, y) == pytest.approx(steering.theta_rad)
    assert not steering.repulsive.any()


def test_the_same_maps_give_the_same_steering(draw_map: DrawMap) -> None:
    maps = [draw_map(corridor, lambda x, _: np.abs(x) > 1.2, (0.05 * k, 0.0, 0.1)) for k in range(6)]
    one, other = ([stage.step(map_, NONE).theta_rad for map_ in maps] for stage in (frontier(), frontier()))
    assert one == other


@pytest.mark.parametrize("far_m", [1e9, 1e308])
def test_of_a_goal_far_away_only_the_bearing_matters(draw_map: DrawMap, far_m: float) -> None:
    map_ = draw_map(unknown=lambda x, y: np.hypot(x, y) > 1.2)
    found = [theta_rad(map_, toward(1.0, distance_m)) for distance_m in (1e6, far_m)]
    assert found[0] == found[1] == pytest.approx(1.0, abs=0.3)
