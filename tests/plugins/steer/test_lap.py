"""The oracle without a goal: around a ring, to either side."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from graphnav_steer.oracle import Oracle, once_around

from graphnav import Latest, Map, State
from graphnav.arrays import Doubles

OUTER_M, INNER_M, SPEED_M = 3.0, 1.6, 0.05


def ring() -> Map:
    """Return a round corridor about the origin, between a disc and a wall of 24 parts."""
    angles = np.linspace(0, 2 * math.pi, 25)
    rim = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    parts = [
        np.array([OUTER_M * a, (OUTER_M + 0.2) * a, (OUTER_M + 0.2) * b, OUTER_M * b])
        for a, b in itertools.pairwise(rim)
    ]
    bodies = [INNER_M * rim[:-1], *parts]
    return Map(
        kind=np.zeros(len(bodies), np.uint8),
        height_m=np.ones(len(bodies)),
        vertices_m=np.concatenate(bodies),
        body=np.repeat(np.arange(len(bodies)), [len(one) for one in bodies]).astype(np.int32),
        start=np.array([0.0, -2.3, 0.0]),
        goal_m=np.zeros((0, 2)),
        robot_radius_m=0.2,
        shortest_m=0.0,
        footprint_m=np.zeros((4, 2)),
    )


def at(place: Doubles, yaw_rad: float) -> State:
    return State(
        x_m=float(place[0]),
        y_m=float(place[1]),
        yaw_rad=yaw_rad,
        v_mps=0.0,
        omega_radps=0.0,
        clearance_m=1.0,
        contact=False,
        at_goal=False,
        moving=np.zeros((0, 3)),
    )


@pytest.mark.parametrize(("yaw_rad", "side"), [(0.0, 1), (math.pi, -1)])
def test_it_goes_round_the_way_that_it_looks(yaw_rad: float, side: int) -> None:
    stage, world = Oracle(), ring()
    stage.reset(seed=0)
    place, places = np.array([0.0, -2.3]), []
    for _ in range(700):
        yaw_rad += stage.step(at(place, yaw_rad), Latest(world, 0.0)).theta_rad
        place = place + SPEED_M * np.array([math.cos(yaw_rad), math.sin(yaw_rad)])
        places.append(place)
    radii = np.linalg.norm(places, axis=1)
    assert radii.min() > INNER_M + 0.2
    assert radii.max() < OUTER_M - 0.2
    bearings = np.unwrap(np.arctan2(*np.array(places).T[::-1]))
    assert side * (bearings[-1] - bearings[0]) > 2 * 2 * math.pi  # more than two laps


def test_the_corridor_is_cut_off_behind_the_robot_from_wall_to_wall() -> None:
    cut = once_around(ring(), at(np.array([0.0, -2.3]), 0.0))
    wall = cut.vertices_m[cut.body == len(cut.kind) - 1]
    assert wall[:, 0] == pytest.approx([-0.8, -0.8, -0.9, -0.9])
    # The disc and the wall where x = -0.8, up to the chords of their polygons.
    assert wall[:, 1].max() == pytest.approx(-math.sqrt(INNER_M**2 - 0.8**2), abs=0.02)
    assert wall[:, 1].min() == pytest.approx(-math.sqrt(OUTER_M**2 - 0.8**2), abs=0.03)
    assert cut.goal_m[:, 0].max() == pytest.approx(-0.9)


def test_what_moves_does_not_end_the_corridor_wherever_its_own_origin_is() -> None:
    world = ring()
    # The robot is 0.8 m ahead of the origin of W, where the outlines of all that moves are.
    place, middle = np.array([0.8, 0.0]), np.array([0.8, 2.3])
    world = replace(world, vertices_m=world.vertices_m + middle)
    mover = 0.2 * np.array([[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]])
    with_mover = replace(
        world,
        kind=np.append(np.uint8(Map.MOVING), world.kind),
        height_m=np.append(1.0, world.height_m),
        vertices_m=np.concatenate([mover, world.vertices_m]),
        body=np.append(np.zeros(len(mover), np.int32), world.body + np.int32(1)),
    )
    cuts = [once_around(one, at(place, 0.0)) for one in (world, with_mover)]
    walls = [cut.vertices_m[cut.body == len(cut.kind) - 1] for cut in cuts]
    assert np.array_equal(*walls)
    assert np.array_equal(cuts[0].goal_m, cuts[1].goal_m)
