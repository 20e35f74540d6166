"""The bodies of a map as solids: outlines extruded to their heights."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from graphnav import Map
from graphnav.arrays import Doubles, Ints

PATH_HEIGHT_M = 0.05
_ROBOT_HEIGHT_M = 0.1
"""Above the floor and above each other, so that all are visible in top view."""
_MIN_HEIGHT_M = 0.02
"""A minimum, so that a body without a height is visible."""


class Body(NamedTuple):
    """A body of a map: ``kind`` as in `Map`, ``outline_m`` (n, 2), ``height_m``."""

    kind: int
    outline_m: Doubles
    height_m: float

    def ring(self, z_m: float) -> Doubles:
        """Return the closed outline at a height, (n + 1, 3)."""
        closed = np.vstack([self.outline_m, self.outline_m[:1]])
        return np.column_stack([closed, np.full(len(closed), z_m)])

    def sides(self) -> tuple[Doubles, Ints]:
        """Return the vertices of the vertical sides, (2n, 3), and their triangles, (2n, 3)."""
        count = len(self.outline_m)
        low = np.column_stack([self.outline_m, np.zeros(count)])
        high = low + np.array([0.0, 0.0, self.height_m])
        here = np.arange(count)
        there = (here + 1) % count
        triangles = np.concatenate(
            [np.stack([here, there, there + count], axis=1), np.stack([here, there + count, here + count], axis=1)]
        )
        return np.concatenate([low, high]), triangles.astype(np.int32)


def bodies_of(world: Map) -> Iterator[Body]:
    """Yield the bodies of a map that can be drawn, in map order: three vertices or more, all finite."""
    for index, kind in enumerate(world.kind.tolist()):
        outline = world.vertices_m[world.body == index]
        height = float(world.height_m[index]) if index < len(world.height_m) else 0.0
        if len(outline) >= 3 and np.isfinite(outline).all() and np.isfinite(height):
            yield Body(kind, outline, max(height, _MIN_HEIGHT_M))


def ring(outline_m: Doubles) -> Doubles | None:
    """Return a closed outline on the floor, (n, 3), None if it has no area or is not finite."""
    if len(outline_m) < 3 or not np.isfinite(outline_m).all():
        return None
    return Body(0, outline_m, 0.0).ring(0.0)


def robot_outline(radius_m: float) -> list[Doubles]:
    """Return a circle around the origin and a line forward from its centre, each (n, 3)."""
    angles = np.linspace(0.0, 2 * np.pi, 37)
    around = radius_m * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))])
    forward = np.array([[0.0, 0.0, 0.0], [2 * radius_m, 0.0, 0.0]])
    return [points + np.array([0.0, 0.0, _ROBOT_HEIGHT_M]) for points in (around, forward)]
