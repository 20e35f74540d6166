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
    first, last = _shares_within(ends_m, begin_rad, end_rad)
    squares = np.einsum("ei,ei->e", along, along)
    foot = -np.einsum("ei,ei->e", begin, along) / np.where(squares > 0, squares, 1.0)
    nearest = begin + np.clip(foot, first, np.maximum(last, first))[:, None] * along
    return np.where(first <= last, np.hypot(nearest[:, 0], nearest[:, 1]), np.inf)


def nearest_to_m(outline_m: Doubles, ends_m: Doubles, begin_rad: float, end_rad: float) -> Doubles:
    """Return how far each edge is from a convex outline (n, 2) that it does not cross, within a sector as `nearest_m`.

    The nearest points of two that do not cross include a vertex of one of them.
    """
    first, last = _shares_within(ends_m, begin_rad, end_rad)
    begin, along = ends_m[0], ends_m[1] - ends_m[0]
    parts = np.stack([begin + share[:, None] * along for share in (first, np.maximum(last, first))])
    sides = np.stack([outline_m, np.roll(outline_m, -1, axis=0)])
    from_ends = [_distances_m(end[:, None], sides[:, None]) for end in parts]
    from_corners = _distances_m(outline_m[None], parts[:, :, None])
    found = np.concatenate([*from_ends, from_corners], axis=1).min(axis=1)
    return np.where(first <= last, found, np.inf)


def _distances_m(points: Doubles, ends: Doubles) -> Doubles:
    """Return how far ``points`` (..., 2) are from segments whose ``ends`` are (2, ..., 2); they broadcast."""
    begin, along = ends[0], ends[1] - ends[0]
    squares = np.maximum((along * along).sum(axis=-1), 1e-18)
    share = np.clip(((points - begin) * along).sum(axis=-1) / squares, 0.0, 1.0)
    away = points - begin - share[..., None] * along
    distances: Doubles = np.hypot(away[..., 0], away[..., 1])
    return distances


def _shares_within(ends_m: Doubles, begin_rad: float, end_rad: float) -> tuple[Doubles, Doubles]:
    """Return from where to where each edge runs in a sector, as shares of its length; the last is less if nowhere."""
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
    return first, last
