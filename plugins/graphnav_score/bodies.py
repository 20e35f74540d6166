"""The bodies of the map around a robot, moving ones where they are: their edges in the robot's frame."""

from __future__ import annotations

import math

import numpy as np

from graphnav import Map, State
from graphnav.arrays import Doubles, Indices


class Bodies:
    """The edges of all bodies of a map.

    Attributes
    ----------
    body
        (edges,), the body of each edge, ascending.
    """

    def __init__(self, world: Map) -> None:
        self.body: Indices = world.body.astype(np.intp)
        self._from_m = world.vertices_m
        self._to_m = world.vertices_m[world.next_vertices()]
        # Of each edge, the row of `State.moving`, and one past the rows for what stands.
        movers = np.flatnonzero(world.kind == Map.MOVING)
        row_of = np.full(len(world.kind), len(movers))
        row_of[movers] = np.arange(len(movers))
        self._row = row_of[self.body]
        self._n_movers = len(movers)

    def edges_m(self, state: State) -> Doubles:
        """Return both ends of each edge in the robot's frame, x forward and y left, (2, edges, 2)."""
        ends = np.stack([self._from_m, self._to_m])
        if self._n_movers:
            poses = np.vstack([state.moving[: self._n_movers], np.zeros(3)])[self._row]
            ends = turned(ends, poses[:, 2]) + poses[:, :2]
        return turned(ends - (state.x_m, state.y_m), np.float64(-state.yaw_rad))


def turned(points: Doubles, angle_rad: Doubles | np.float64) -> Doubles:
    """Return ``points`` (..., 2) turned counterclockwise about the origin; ``angle_rad`` broadcasts against (...)."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    x, y = points[..., 0], points[..., 1]
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


def nearest_m(ends_m: Doubles, begin_rad: float, end_rad: float) -> Doubles:
    """Return how far each edge is from the origin within a sector, infinite where it does not reach into it; (edges,).

    ``ends_m``: (2, edges, 2). The sector runs counterclockwise from ``begin_rad`` to ``end_rad``, at most half a turn.
    """
    begin, along = ends_m[0], ends_m[1] - ends_m[0]
    first, last = np.zeros(len(begin)), np.ones(len(begin))
    # A point p is in the sector if it is left of its first side and right of its last one: n.p >= 0 for both normals.
    for normal in (
        np.array([-math.sin(begin_rad), math.cos(begin_rad)]),
        np.array([math.sin(end_rad), -math.cos(end_rad)]),
    ):
        inside, growth = begin @ normal, along @ normal
        with np.errstate(divide="ignore", invalid="ignore"):
            crossing = -inside / growth
        first = np.where(growth > 0, np.maximum(first, crossing), first)
        last = np.where(growth < 0, np.minimum(last, crossing), last)
        last = np.where((growth == 0) & (inside < 0), -1.0, last)
    squares = np.einsum("ei,ei->e", along, along)
    foot = -np.einsum("ei,ei->e", begin, along) / np.where(squares > 0, squares, 1.0)
    nearest = begin + np.clip(foot, first, np.maximum(last, first))[:, None] * along
    return np.where(first <= last, np.hypot(nearest[:, 0], nearest[:, 1]), np.inf)
