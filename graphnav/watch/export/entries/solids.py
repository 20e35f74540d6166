"""The scene of a run as lines and sides in space, for viewers in three dimensions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from graphnav import Scene, SceneArea
from graphnav.arrays import Doubles, Ints
from graphnav.watch.export.entries.entries import Path, Robot

Rgb = tuple[float, float, float]

_ROBOT: Rgb = (1.0, 0.70, 0.15)
"""Visible on dark and light backgrounds, other than the robot's colour in pictures."""
_PATH_HEIGHT_M, _ROBOT_HEIGHT_M = 0.05, 0.1
"""Above the floor and above each other, so that all are visible in top view."""
_MIN_HEIGHT_M = 0.02
"""A minimum, so that a body without a height is visible."""


@dataclass(frozen=True)
class Solid:
    """A part of a scene in one colour, 0 to 1 each.

    ``lines``: (n, 3), metres; ``sides``: vertices (n, 3) and the indices of triangles (m, 3), None for mere lines.
    ``moving``: the number of the moving obstacle in whose frame it is given, None in W, or in R for the robot's.
    """

    colour: Rgb
    lines: tuple[Doubles, ...]
    sides: tuple[Doubles, Ints] | None = None
    moving: int | None = None


def goal_of(scene: Scene) -> Solid | None:
    """Return the outline of the goal region on the floor, None without one."""
    return next((_on_floor(area) for area in scene.fixed if area.role == "goal"), None)


def bodies_of(scene: Scene) -> Iterator[Solid]:
    """Yield walls, obstacles and moving obstacles, extruded to their heights."""
    yield from (_body(area, None) for area in scene.fixed if area.role != "goal")
    yield from (_body(area, number) for number, area in enumerate(scene.moving) if area is not None)


def robot_of(entry: Robot) -> list[Solid]:
    """Return the robot in R, its circle or outline and a line forward, and what its camera sees of the floor."""
    angles = np.linspace(0.0, 2 * np.pi, 37)
    around = entry.radius_m * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))])
    if entry.body is not None:
        around = _ring(entry.body, 0.0)
    forward = np.array([[0.0, 0.0, 0.0], [2 * entry.radius_m, 0.0, 0.0]])
    up = np.array([0.0, 0.0, _ROBOT_HEIGHT_M])
    seen = [] if entry.seen is None else [_on_floor(entry.seen)]
    return [Solid(_ROBOT, (around + up, forward + up)), *seen]


def path_of(entry: Path) -> Solid:
    """Return the robot's path."""
    return Solid(_ROBOT, (np.column_stack([entry.points_m, np.full(len(entry.points_m), _PATH_HEIGHT_M)]),))


def _on_floor(area: SceneArea) -> Solid:
    return Solid(_rgb(area), (_ring(area, 0.0),))


def _body(area: SceneArea, moving: int | None) -> Solid:
    height_m, count = max(area.height_m, _MIN_HEIGHT_M), len(area.outline_m)
    low = np.column_stack([area.outline_m, np.zeros(count)])
    here = np.arange(count)
    there = (here + 1) % count
    triangles = np.concatenate(
        [np.stack([here, there, there + count], axis=1), np.stack([here, there + count, here + count], axis=1)]
    )
    sides = np.concatenate([low, low + np.array([0.0, 0.0, height_m])]), triangles.astype(np.int32)
    return Solid(_rgb(area), (_ring(area, 0.0), _ring(area, height_m)), sides, moving)


def _ring(area: SceneArea, z_m: float) -> Doubles:
    """Return the closed outline at a height, (n + 1, 3)."""
    closed = np.vstack([area.outline_m, area.outline_m[:1]])
    return np.column_stack([closed, np.full(len(closed), z_m)])


def _rgb(area: SceneArea) -> Rgb:
    red, green, blue = bytes.fromhex(area.colour[1:])
    return red / 255, green / 255, blue / 255
