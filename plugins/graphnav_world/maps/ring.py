"""A corridor without an end, drawn from ranges: around a rectangle with round corners."""

from __future__ import annotations

import math

import numpy as np

from graphnav.arrays import Doubles
from graphnav_world.geometry import outlines
from graphnav_world.maps.corridor import Corridor, start, turn_sign, wall
from graphnav_world.maps.corridor_keys import RingKeys
from graphnav_world.maps.draws import Draws


def draw_ring(draws: Draws, keys: RingKeys) -> Corridor | None:
    """Return a corridor without a goal, None if it cannot be one."""
    length, width, radius = (draws.number(one) for one in (keys.length_m, keys.width_m, keys.radius_m))
    half, thickness, side = draws.number(keys.half_width_m), draws.number(keys.thickness_m), turn_sign(draws, keys)
    if half + thickness >= radius:
        draws.unfit(keys.place("half_width_m"), "the ring is wider than its corners", "give a smaller half_width_m")
        return None
    if 2 * radius > min(length, width):
        what = "the corners of the ring are rounder than it is long or wide"
        draws.unfit(keys.place("radius_m"), what, "give a smaller radius_m")
        return None
    flip = np.array([1.0, side])
    reach = half + thickness / 2
    rims = (_loop(length, width, radius, offset) * flip for offset in (-reach, reach))
    return Corridor([wall(draws, keys, rim) for rim in rims], start(draws, keys), np.zeros((0, 2)))


def _loop(length: float, width: float, radius: float, inward: float) -> Doubles:
    """Return a rectangle with round corners, moved inwards, counterclockwise; its lower side passes the origin."""
    across, up = length / 2 - radius, width / 2 - radius
    middles = [(across, -up), (across, up), (-across, up), (-across, -up)]
    corners = [
        outlines.arc((x, y + width / 2), radius - inward, (k - 1) * math.pi / 2, k * math.pi / 2)
        for k, (x, y) in enumerate(middles)
    ]
    loop = np.concatenate(corners)
    return _without_repetitions(loop)


def _without_repetitions(loop: Doubles) -> Doubles:
    """Return a loop without points that repeat the one before, which the ends of two arcs without a straight do."""
    steps = np.linalg.norm(loop - np.roll(loop, 1, axis=0), axis=1)
    kept: Doubles = loop[steps > 1e-9]
    return kept
