"""Rays in the plane: how far they go until they meet the side of a body."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from graphnav.arrays import Doubles, Indices
from graphnav_world.geometry.movers import Mover
from graphnav_world.geometry.scene import Body

_MIN_MOMENT_M2 = 1e-9
"""A side that points to the viewer more closely is met by no ray; its neighbours are."""
_BEYOND_RAD = 1e-12
"""By how much a side reaches beyond its ends: rounding opens no gap between neighbours."""


class Beams(NamedTuple):
    """Directions ``first_rad + k * step_rad`` of ``n`` rays, within one turn; ``step_rad`` is positive."""

    first_rad: float
    step_rad: float
    n: int


class Sides:
    """The vertical sides of the bodies that reach a height, as segments on the floor.

    Parameters
    ----------
    bodies
        All bodies of a map.
    movers
        Those that move, in the order of the bodies, as `movers_of` makes them.
    height_m
        Height of the rays above the floor; lower bodies are passed over.
    """

    def __init__(self, bodies: Sequence[Body], movers: Sequence[Mover], height_m: float) -> None:
        left = iter(movers)
        self._moving: list[tuple[Doubles, Mover]] = []
        standing = [np.zeros((0, 2, 2))]
        for body in bodies:
            mover = None if body.course is None else next(left)
            if body.height_m < height_m:
                continue
            if mover is None:
                standing.append(body.sides)
            else:
                self._moving.append((body.sides, mover))
        self._standing = np.concatenate(standing)

    def at(self, time_s: float) -> Doubles:
        """Return the sides in W at a time, (n, 2, 2), from and to, counterclockwise around their bodies."""
        return np.concatenate([self._standing, *(sides + mover.at(time_s) for sides, mover in self._moving)])


def distances_m(sides: Doubles, beams: Beams) -> Doubles:
    """Return how far each ray from the origin goes until it meets a side from outside, (beams,), infinite if none.

    ``sides``: (n, 2, 2), counterclockwise around their bodies. Each side is met by the rays between its ends alone, so
    that the time grows with the sides and the rays that meet them, not with their product.
    """
    begin, along = sides[:, 0], sides[:, 1] - sides[:, 0]
    moment = begin[:, 0] * along[:, 1] - begin[:, 1] * along[:, 0]
    # Seen from outside a body, its sides run clockwise around the viewer.
    faces = np.flatnonzero(moment < -_MIN_MOMENT_M2)
    low_rad = np.arctan2(sides[faces, 1, 1], sides[faces, 1, 0])
    high_rad = np.arctan2(begin[faces, 1], begin[faces, 0])
    side, ray = _met(low_rad, np.remainder(high_rad - low_rad, 2 * math.pi), beams)
    side = faces[side]
    angle = beams.first_rad + beams.step_rad * ray
    crossing = np.cos(angle) * along[side, 1] - np.sin(angle) * along[side, 0]
    found = np.full(beams.n, math.inf)
    np.minimum.at(found, ray, moment[side] / crossing)
    return found


def _met(low_rad: Doubles, width_rad: Doubles, beams: Beams) -> tuple[Indices, Indices]:
    """Return the pairs of a side and a ray in it; side k spans from ``low_rad[k]`` counterclockwise."""
    turn_rad = 2 * math.pi
    from_first = np.remainder(low_rad - beams.first_rad, turn_rad) - _BEYOND_RAD
    # A side that begins before the first ray and reaches it is met by the first rays, too.
    begin_rad = np.concatenate([from_first, from_first - turn_rad])
    first = np.maximum(np.ceil(begin_rad / beams.step_rad), 0).astype(np.intp)
    last = np.floor((begin_rad + np.tile(width_rad, 2) + 2 * _BEYOND_RAD) / beams.step_rad).astype(np.intp)
    counts = np.maximum(np.minimum(last, beams.n - 1) - first + 1, 0)
    side = np.repeat(np.tile(np.arange(len(low_rad)), 2), counts)
    offset = np.arange(len(side)) - np.repeat(np.cumsum(counts) - counts, counts)
    return side, np.repeat(first, counts) + offset
