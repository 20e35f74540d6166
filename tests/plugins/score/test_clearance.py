"""Clearance ahead and to the sides, against points sampled along the outlines of all bodies."""

from __future__ import annotations

import math

import numpy as np
import pytest
from graphnav_score.bodies import Bodies, nearest_m
from graphnav_score.clearance import SectorClearance
from graphnav_score.navigation import Navigation

from graphnav import Latest, Map, Stamp, State
from graphnav.arrays import Doubles

RADIUS_M = 0.2


def box(x: float, y: float, length: float, width: float) -> Doubles:
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    return np.asarray(corners * (length / 2, width / 2) + (x, y))


def world(*bodies: Doubles, moving: tuple[int, ...] = ()) -> Map:
    kind = np.ones(len(bodies), np.uint8)
    kind[list(moving)] = 2
    return Map(
        kind=kind,
        height_m=np.ones(len(bodies)),
        vertices_m=np.concatenate([np.zeros((0, 2)), *bodies]),
        body=np.repeat(np.arange(len(bodies)), [len(one) for one in bodies]).astype(np.int32),
        start=np.zeros(3),
        goal_m=np.zeros((0, 2)),
        robot_radius_m=RADIUS_M,
        shortest_m=0.0,
        footprint_m=np.zeros((0, 2)),
    )


def at(x_m: float = 0.0, y_m: float = 0.0, yaw_rad: float = 0.0, moving: Doubles | None = None) -> State:
    return State(
        x_m=x_m,
        y_m=y_m,
        yaw_rad=yaw_rad,
        v_mps=0.3,
        omega_radps=0.0,
        clearance_m=0.0,
        contact=False,
        at_goal=False,
        moving=np.zeros((0, 3)) if moving is None else moving,
    )


def clearance(world_: Map, state: State, driven_m: float = 2.0) -> tuple[float | None, float | None]:
    sectors = SectorClearance(world_)
    sectors.add(state, driven_m)
    metrics = sectors.metrics()
    return metrics.get("min_clearance_ahead_m"), metrics.get("min_clearance_side_m")


@pytest.mark.parametrize("yaw_rad", [0.0, 1.0, math.pi / 2, -2.5])
def test_a_body_counts_where_it_is(yaw_rad: float) -> None:
    for bearing, ahead, side in ((0.0, True, False), (math.pi / 2, False, True), (-math.pi / 2, False, True)):
        angle = yaw_rad + bearing
        there = (3.0 + 2 * math.cos(angle), 1.0 + 2 * math.sin(angle))
        found = clearance(world(box(*there, 1e-6, 1e-6)), at(3.0, 1.0, yaw_rad))
        for value, counts in zip(found, (ahead, side), strict=True):
            assert value == (pytest.approx(2.0 - RADIUS_M, abs=1e-5) if counts else None)


def test_what_is_behind_counts_in_no_sector() -> None:
    assert clearance(world(box(-1.0, 0.0, 0.2, 0.2)), at()) == (None, None)


def test_a_long_wall_beside_the_robot_is_beside_and_ahead_of_it() -> None:
    ahead, side = clearance(world(box(0.0, 1.05, 100.0, 0.1)), at())
    assert side == pytest.approx(1.0 - RADIUS_M)
    assert ahead == pytest.approx(math.sqrt(2) - RADIUS_M), "where the wall enters the sector, at 45 degrees"


@pytest.mark.parametrize("seed", range(5))
def test_distances_are_those_of_sampled_points(seed: int) -> None:
    rng = np.random.default_rng(seed)
    ends = rng.uniform(-2, 2, (2, 30, 2))
    points = ends[0] + np.linspace(0, 1, 20001)[:, None, None] * (ends[1] - ends[0])
    angle, far = np.arctan2(points[..., 1], points[..., 0]), np.hypot(points[..., 0], points[..., 1])
    for begin in (-math.pi / 4, math.pi / 4, -3 * math.pi / 4):
        inside = (angle - begin) % (2 * math.pi) <= math.pi / 2
        expected = np.where(inside, far, np.inf).min(axis=0)
        found = nearest_m(ends, begin, begin + math.pi / 2)
        grazes = np.isfinite(found) & ~np.isfinite(expected)
        assert found[~grazes] == pytest.approx(expected[~grazes], abs=1e-3)
        assert not grazes.any()


def test_moving_bodies_are_where_the_state_says() -> None:
    walls = box(0.0, 3.0, 10.0, 0.1), box(0.0, 0.0, 0.2, 1.0), box(0.0, -3.0, 10.0, 0.1)
    moved = at(moving=np.array([[1.5, 0.0, math.pi / 2]]))
    ahead, side = clearance(world(*walls, moving=(1,)), moved)
    assert ahead == pytest.approx(1.0 - RADIUS_M), "turned, the box reaches half a metre towards the robot"
    assert side == pytest.approx(2.95 - RADIUS_M)


def test_the_first_metre_does_not_count() -> None:
    assert clearance(world(box(1.0, 0.0, 0.2, 0.2)), at(), driven_m=0.99) == (None, None)
    assert clearance(world(box(1.0, 0.0, 0.2, 0.2)), at(), driven_m=1.0)[0] == pytest.approx(0.9 - RADIUS_M)


def test_a_map_without_bodies_has_no_clearance() -> None:
    assert clearance(world(), at()) == (None, None)
    assert Bodies(world()).edges_m(at()).shape == (2, 0, 2)


def test_the_edges_of_each_body_close() -> None:
    bodies = Bodies(world(box(0, 0, 1, 1), box(5, 5, 1, 2)))
    lengths = np.hypot(*np.diff(bodies.edges_m(at()), axis=0)[0].T)
    assert lengths == pytest.approx([1, 1, 1, 1, 1, 2, 1, 2])


def test_a_drive_reports_both() -> None:
    stage = Navigation()
    stage.reset(0)
    world_ = Latest(world(box(3.0, 0.0, 0.2, 0.2), box(0.0, 1.05, 100.0, 0.1)), 0.0)
    for k in range(16):
        stage.step(at(0.1 * k), world_, Stamp(100_000 * k))
    metrics = stage.summary()
    assert metrics["min_clearance_ahead_m"] == pytest.approx(3.0 - 0.1 - 1.5 - RADIUS_M)
    assert metrics["min_clearance_side_m"] == pytest.approx(1.0 - RADIUS_M)


JACKAL = (0.508, 0.43)


def rectangular(*bodies: Doubles) -> Map:
    """Return a world whose robot is a rectangle."""
    shown = world(*bodies, box(0.0, 0.0, *JACKAL))
    shown.kind[-1] = Map.ROBOT
    return shown


def test_a_rectangle_is_as_near_as_its_sides() -> None:
    ahead, left = box(2.0, 0.0, 0.2, 0.2), box(0.0, 1.0, 0.2, 0.2)
    half_length, half_width = JACKAL[0] / 2, JACKAL[1] / 2
    for yaw_rad, expected in (
        (0.0, (1.9 - half_length, 0.9 - half_width)),
        (math.pi / 2, (0.9 - half_length, 1.9 - half_width)),
    ):
        for value, wanted in zip(clearance(rectangular(ahead, left), at(yaw_rad=yaw_rad)), expected, strict=True):
            assert value == pytest.approx(wanted)
    assert clearance(rectangular(), at()) == (None, None), "it is not its own obstacle"


@pytest.mark.parametrize("seed", range(5))
def test_a_rectangle_is_as_near_as_points_of_the_outlines_within_the_sector(seed: int) -> None:
    rng = np.random.default_rng(seed)
    bodies = [box(*(1.2 * _on_circle(angle)), *rng.uniform(0.1, 0.6, 2)) for angle in rng.uniform(0, 2 * math.pi, 6)]
    ends = np.concatenate([np.stack([one, np.roll(one, -1, axis=0)], axis=1) for one in bodies])
    shares = np.linspace(0.0, 1.0, 2001)[:, None, None]
    points = (ends[:, 0] + shares * (ends[:, 1] - ends[:, 0])).reshape(-1, 2)
    bearing = np.abs(np.arctan2(points[:, 1], points[:, 0]))
    away = np.hypot(*np.maximum(np.abs(points) - np.array(JACKAL) / 2, 0.0).T)
    expected = (away[bearing <= math.pi / 4], away[np.abs(bearing - math.pi / 2) <= math.pi / 4])
    found = clearance(rectangular(*bodies), at())
    for value, within in zip(found, expected, strict=True):
        assert value == (pytest.approx(within.min(), abs=1e-3) if len(within) else None)


def _on_circle(angle_rad: float) -> Doubles:
    return np.array([math.cos(angle_rad), math.sin(angle_rad)])
