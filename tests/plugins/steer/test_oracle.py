"""The oracle on maps drawn by hand, with a unicycle that obeys, and on a map that ships."""

from __future__ import annotations

import math

import numpy as np
import pytest
from graphnav_steer.oracle import Oracle
from graphnav_steer.way import CELL_M, Way

from graphnav import Latest, Map, State
from graphnav.arrays import Doubles
from graphnav.core.catalog import Catalog
from graphnav.core.graph import Override, load_graph
from graphnav.core.runner import Lockstep

RADIUS_M = 0.2


def box(x: float, y: float, length: float, width: float) -> Doubles:
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    return np.asarray(corners * (length / 2, width / 2) + (x, y))


def world(*bodies: Doubles, goal_m: Doubles | None = None, kind: int = 1, mirrored: bool = False) -> Map:
    """Return a map with these bodies, a start at the origin and a goal 5 m ahead."""
    goal_m = box(5, 0, 1, 1) if goal_m is None else goal_m
    flip = np.array([1.0, -1.0]) if mirrored else np.ones(2)
    return Map(
        kind=np.full(len(bodies), kind, np.uint8),
        height_m=np.ones(len(bodies)),
        vertices_m=np.concatenate([np.zeros((0, 2)), *bodies]) * flip,
        body=np.repeat(np.arange(len(bodies)), [len(one) for one in bodies]).astype(np.int32),
        start=np.zeros(3),
        goal_m=goal_m * flip,
        robot_radius_m=RADIUS_M,
        shortest_m=5.0,
        footprint_m=np.zeros((4, 2)),
    )


def at(x_m: float, y_m: float, yaw_rad: float) -> State:
    return State(
        x_m=x_m,
        y_m=y_m,
        yaw_rad=yaw_rad,
        v_mps=0.0,
        omega_radps=0.0,
        clearance_m=1.0,
        contact=False,
        at_goal=False,
        moving=np.zeros((0, 3)),
    )


def drive(map_: Map, frames: int = 400, yaw_rad: float = 0.0) -> Doubles:
    """Return the places, (n, 2), of a unicycle that does at once what it is told, until the goal or the last frame."""
    stage = Oracle()
    stage.reset(seed=0)
    x = y = 0.0
    places = [(x, y)]
    lows, highs = map_.goal_m.min(axis=0), map_.goal_m.max(axis=0)
    for _ in range(frames):
        theta = stage.step(at(x, y, yaw_rad), Latest(map_, 0.0)).theta_rad
        forward_m = 0.03 * max(math.cos(theta), 0.0)
        yaw_rad += 0.12 * (math.sin(theta) if abs(theta) < math.pi / 2 else math.copysign(1.0, theta))
        x, y = x + forward_m * math.cos(yaw_rad), y + forward_m * math.sin(yaw_rad)
        places.append((x, y))
        if lows[0] < x < highs[0] and lows[1] < y < highs[1]:
            break
    return np.array(places)


def test_drives_around_what_stands_in_the_way_without_touching_it() -> None:
    blocked = world(box(2.5, 0.3, 0.4, 2.0))
    places = drive(blocked)
    assert 4.5 < places[-1, 0] < 5.5
    outside = np.abs(places - (2.5, 0.3)) - (0.2, 1.0)
    clearance_m = np.hypot(*np.maximum(outside, 0.0).T) - RADIUS_M
    assert clearance_m.min() > 0.05
    length_m = np.hypot(*np.diff(places, axis=0).T).sum()
    around_m = 2 * math.hypot(2.3, 0.9) + 0.4  # past the nearer corner, at a radius; the goal is as far behind
    assert length_m < 1.1 * around_m


def test_mirrored_map_mirrors_the_drive() -> None:
    obstacles = box(2.0, 0.3, 0.4, 1.4), box(3.5, -0.6, 0.5, 0.8)
    as_is, mirrored = drive(world(*obstacles)), drive(world(*obstacles, mirrored=True))
    assert np.abs(as_is[:, 1]).max() > 0.3
    n = min(len(as_is), len(mirrored))
    assert np.allclose(as_is[:n], mirrored[:n] * [1, -1], atol=2 * CELL_M)


def test_obstacle_on_the_right_turns_the_robot_left() -> None:
    def first(map_: Map) -> float:
        stage = Oracle()
        stage.reset(seed=0)
        return stage.step(at(0.0, 0.0, 0.0), Latest(map_, 0.0)).theta_rad

    assert first(world(box(0.7, -0.4, 0.4, 1.0))) > 0.1
    assert first(world(box(0.7, 0.4, 0.4, 1.0))) < -0.1
    assert first(world()) == pytest.approx(0.0, abs=0.05)


def test_turns_on_the_spot_to_a_goal_behind() -> None:
    places = drive(world(), yaw_rad=2.5)
    assert np.abs(places[:, 1]).max() < 0.5
    assert places[-1, 0] > 4.5


def test_costs_are_distances_where_nothing_is_near() -> None:
    way = Way(world(), comfort_m=0.25, wall_cost=4.0)
    # Sixteen directions: a way on the grid is at most 1 / cos(13.3 deg) = 2.8 % longer than the straight one.
    for x, y in ((0.0, 0.0), (1.0, 0.4), (-0.5, -0.3)):
        straight_m = 4.5 + 0.1 - x
        assert way.cost(x, y) == pytest.approx(straight_m, rel=0.03, abs=2 * CELL_M)


def test_what_moves_is_ignored() -> None:
    moving, free = world(box(2.5, 0.0, 0.4, 2.0), kind=2), world()
    assert Way(moving, 0.25, 4.0).cost(0.0, 0.0) == pytest.approx(Way(free, 0.25, 4.0).cost(0.0, 0.0), abs=1e-9)


def test_robot_in_a_corner_that_it_should_not_be_in_finds_out() -> None:
    places = drive(world(box(0.35, 0.0, 0.2, 4.0)))  # its rim is 5 cm from the wall, nearer than a plan would be
    assert places[-1, 0] > 4.5


def test_enclosed_robot_still_gets_a_finite_direction() -> None:
    walls = box(0, 1, 3, 0.2), box(0, -1, 3, 0.2), box(1.5, 0, 0.2, 2.2), box(-1.5, 0, 0.2, 2.2)
    stage = Oracle()
    stage.reset(seed=0)
    assert stage.step(at(0.0, 0.0, 0.3), Latest(world(*walls), 0.0)).not_finite() is None


def test_missing_map_and_missing_goal_are_said() -> None:
    stage = Oracle()
    stage.reset(seed=0)
    with pytest.raises(ValueError, match=r"connect it: --set steer\.in\.map=robot\.map"):
        stage.step(at(0.0, 0.0, 0.0), Latest())
    with pytest.raises(ValueError, match="has no goal"):
        stage.step(at(0.0, 0.0, 0.0), Latest(world(goal_m=np.zeros((0, 2))), 0.0))


@pytest.mark.parametrize("graph", ["corridor_ccw", "pillars"])
def test_swapped_in_it_nears_the_goal_of_a_map_that_ships(graph: str) -> None:
    sets = ["steer=steer.oracle", "steer.in.map=robot.map", "run.seed=7"]
    loaded = load_graph(graph, Catalog(), [*map(Override.parse, sets)])
    stages = loaded.make_stages()
    lockstep = Lockstep(loaded, stages, [])
    lockstep.reset(7)
    for _ in range(40):
        assert lockstep.tick() is None
    assert stages["drive"].summary()["path_length_m"] > 0.8
    lockstep.engine.close()
