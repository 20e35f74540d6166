"""The centreline of a closed corridor, by the bearing from its middle."""

from __future__ import annotations

import math

import numpy as np

from graphnav import Map
from graphnav.arrays import Doubles

_BEARINGS = 360


class Centreline:
    """Lengths along the middle of a closed corridor around ``middle_m``, (x, y) in W.

    A ray a degree leaves the middle. Where it passes the outlines of what stands, its longest piece between two of them
    is the corridor, and the middle of that piece is on the centreline.
    """

    def __init__(self, points_m: Doubles) -> None:
        ways = np.hypot(*(np.roll(points_m, -1, axis=0) - points_m).T)
        self._length_m = np.concatenate([[0.0], np.cumsum(ways)])

    @classmethod
    def of(cls, world: Map, middle_m: tuple[float, float]) -> Centreline | None:
        """Return the centreline of a map's corridor; None if some ray does not pass between two outlines."""
        starts, ends = _edges(world, middle_m)
        points: list[Doubles] = []
        for bearing_rad in _bearings():
            ray = np.array([math.cos(bearing_rad), math.sin(bearing_rad)])
            away_m = _crossings_m(ray, starts, ends)
            if len(away_m) < 2:
                return None
            widest = int(np.argmax(np.diff(away_m)))
            points.append(ray * (away_m[widest] + away_m[widest + 1]) / 2)
        return cls(np.array(points))

    def along_m(self, bearing_rad: float) -> float:
        """Return the length from bearing 0 to this one, which may be of several turns, to either side."""
        turns, share = divmod(bearing_rad / (2 * math.pi), 1.0)
        within = np.interp(share * _BEARINGS, np.arange(_BEARINGS + 1), self._length_m)
        return float(turns * self._length_m[-1] + within)


def _bearings() -> Doubles:
    return np.asarray(np.arange(_BEARINGS) * (2 * math.pi / _BEARINGS), np.float64)


def _edges(world: Map, middle_m: tuple[float, float]) -> tuple[Doubles, Doubles]:
    """Return where the edges of all that stands begin and end, from the middle, each (n, 2)."""
    outlines = [world.vertices_m[world.body == body] for body in np.flatnonzero(world.kind != Map.MOVING)]
    starts = [outline - np.array(middle_m) for outline in outlines]
    ends = [np.roll(start, -1, axis=0) for start in starts]
    return np.concatenate([np.zeros((0, 2)), *starts]), np.concatenate([np.zeros((0, 2)), *ends])


def _crossings_m(ray: Doubles, starts: Doubles, ends: Doubles) -> Doubles:
    """Return how far along a ray of length 1 it crosses edges, sorted."""
    along, across = starts @ ray, starts @ np.array([-ray[1], ray[0]])
    to_along, to_across = ends @ ray, ends @ np.array([-ray[1], ray[0]])
    crosses = (across > 0) != (to_across > 0)
    share = across[crosses] / (across[crosses] - to_across[crosses])
    away_m: Doubles = along[crosses] + share * (to_along[crosses] - along[crosses])
    return np.sort(away_m[away_m > 0])
