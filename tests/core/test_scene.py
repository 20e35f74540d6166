"""A scene holds what of a map can be drawn, where it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from graphnav import Scene
from graphnav.arrays import Doubles
from graphnav.core.messages import Map

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
AWAY = SQUARE + np.array([4.0, 0.0])
KINDS = [Map.OBSTACLE, Map.WALL, Map.MOVING, Map.MOVING]


def world(*outlines: Doubles) -> Map:
    """Return a map of an obstacle, a wall, and two moving obstacles, with a goal and a camera."""
    return Map(
        kind=np.array(KINDS, np.uint8),
        height_m=np.array([0.5, 1.0, 0.8]),
        vertices_m=np.concatenate(outlines),
        body=np.repeat(np.arange(len(outlines), dtype=np.int32), [len(one) for one in outlines]),
        start=np.array([-1.0, 0.0, 0.0]),
        goal_m=SQUARE + 8,
        robot_radius_m=0.2,
        shortest_m=9.0,
        footprint_m=SQUARE,
    )


WORLD = world(SQUARE, AWAY, SQUARE - 0.5, SQUARE - 0.5)


def test_areas_are_in_the_order_in_which_they_are_painted() -> None:
    scene = Scene(WORLD)
    assert [area.role for area in scene.fixed] == ["goal", "wall", "obstacle"]
    assert [area.height_m for area in scene.fixed] == [0.0, 1.0, 0.5]
    assert [area.height_m if area else None for area in scene.moving] == [0.8, 0.0], "one has no height"
    assert scene.fixed[1].outline_m == pytest.approx(AWAY)
    assert [area.opacity_ratio for area in scene.fixed] == [0.4, 1.0, 1.0]


def test_the_vertices_of_a_body_need_not_stand_together() -> None:
    order = np.random.default_rng(7).permutation(len(WORLD.body))
    by_body = order[np.argsort(WORLD.body[order], kind="stable")]
    scene = Scene(replace(WORLD, vertices_m=WORLD.vertices_m[order], body=WORLD.body[order]))
    assert scene.fixed[2].outline_m == pytest.approx(WORLD.vertices_m[by_body][:4])


@pytest.mark.parametrize("spoiled", [SQUARE[:2], SQUARE * np.nan, np.full((4, 2), np.inf), SQUARE[:0]])
def test_what_cannot_be_drawn_is_left_out_and_the_others_keep_their_poses(spoiled: Doubles) -> None:
    scene = Scene(replace(world(spoiled, SQUARE, spoiled, SQUARE), goal_m=spoiled, footprint_m=spoiled))
    assert [area.role for area in scene.fixed] == ["wall"]
    assert scene.seen is None
    assert scene.moving[0] is None
    poses = np.array([[9.0, 9.0, 0.0], [2.0, 3.0, np.pi / 2]])
    (placed,) = scene.moving_at(poses)
    assert placed.outline_m == pytest.approx(np.array([[2, 3], [2, 4], [1, 4], [1, 3]]))
    assert scene.moving_at(poses[:1]) == []
    assert scene.moving_at(poses * np.nan) == []


def test_fewer_vertices_than_bodies_say_are_no_error() -> None:
    assert len(Scene(replace(WORLD, vertices_m=WORLD.vertices_m[:6])).fixed) == 2


def test_bounds_hold_everything_at_all_times() -> None:
    moving = np.array([[[0.0, 20.0, 0.0]] * 2, [[0.0, -20.0, 0.0]] * 2])
    low, high = Scene(WORLD).bounds_m([np.array([[30.0, 0.0]])], moving, 0.25)
    assert low == pytest.approx([-1.25, -20.75])
    assert high == pytest.approx([30.25, 20.75])


def test_the_nearest_point_is_on_a_body_and_never_on_the_goal() -> None:
    scene, poses = Scene(WORLD), np.array([[20.0, 20.0, 0.0]] * 2)
    assert scene.nearest_point(poses, np.array([4.4, -2.0])) == pytest.approx([4.4, 0.0])
    assert scene.nearest_point(poses, np.array([8.5, 8.5])) == pytest.approx([5.0, 1.0])
    assert scene.nearest_point(poses, np.array([19.0, 20.0])) == pytest.approx([19.5, 20.0])
    empty = Scene(replace(WORLD, kind=WORLD.kind[:0]))
    assert empty.nearest_point(poses, np.array([1.0, 2.0])) == pytest.approx([1.0, 2.0])


def test_a_robot_that_is_no_disc_has_an_outline_and_is_no_obstacle() -> None:
    hull = (SQUARE - 0.5) * (0.5, 0.4)
    around = replace(WORLD, height_m=np.ones(4))
    rectangle = replace(
        around,
        kind=np.append(WORLD.kind, np.uint8(Map.ROBOT)),
        height_m=np.ones(5),
        vertices_m=np.concatenate([WORLD.vertices_m, hull]),
        body=np.append(WORLD.body, np.full(4, 4, np.int32)),
    )
    scene = Scene(rectangle)
    assert scene.robot is not None
    assert scene.robot.outline_m == pytest.approx(hull)
    assert Scene(around).robot is None
    assert [area.role for area in (*scene.fixed, *scene.moving) if area] == [
        area.role for area in (*Scene(around).fixed, *Scene(around).moving) if area
    ]
    assert rectangle.robot_outline_m == pytest.approx(hull)
    kept = rectangle.surroundings()
    for name in ("kind", "height_m", "vertices_m", "body"):
        assert (getattr(kept, name) == getattr(around, name)).all()
    assert around.surroundings() is around
