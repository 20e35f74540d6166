"""A corridor with sharp corners to alternate sides, drawn from ranges; some of them are T junctions."""

from __future__ import annotations

import math

import numpy as np

from graphnav.arrays import Doubles
from graphnav_world.geometry import outlines
from graphnav_world.maps.corridor import BEHIND_START_M, BEYOND_GOAL_M, GOAL_M, Corridor, across, start, turn_sign, wall
from graphnav_world.maps.corridor_keys import ZigzagKeys
from graphnav_world.maps.draws import Draws


def draw_zigzag(draws: Draws, keys: ZigzagKeys) -> Corridor | None:
    """Return a corridor, None if it cannot be one. The run-in begins at the origin, along x."""
    half, thickness = draws.number(keys.half_width_m), draws.number(keys.thickness_m)
    count = draws.count(keys.corners)
    rng = draws.rng("zigzag")
    sides = turn_sign(draws, keys) * (-1.0) ** np.arange(count)
    turns = sides * np.radians(rng.uniform(keys.corner_deg.low, keys.corner_deg.high, count))
    straights = rng.uniform(keys.straight_m.low, keys.straight_m.high, count)
    headings = np.concatenate([[0.0], np.cumsum(turns)])
    along = np.stack([np.cos(headings), np.sin(headings)], axis=1)
    lengths = np.concatenate([[draws.number(keys.run_in_m)], straights])
    ends = np.cumsum(along * lengths[:, None], axis=0)  # the corners, and where the goal begins
    line = np.concatenate([[[-BEHIND_START_M, 0.0]], ends[:-1], ends[-1:] + (GOAL_M + BEYOND_GOAL_M) * along[-1]])

    reach = half + thickness / 2
    strip = outlines.strip(line, 2 * reach, closed=False)
    rims = {1.0: [[point] for point in strip.right], -1.0: [[point] for point in strip.left]}  # by the corner's side
    dead_ends = min(draws.count(keys.dead_ends), count)
    for corner in rng.permutation(count)[:dead_ends]:
        dead_end_m = rng.uniform(keys.dead_end_m.low, keys.dead_end_m.high)
        rims[sides[corner]][corner + 1] = _dead_end(ends[corner], along[corner], turns[corner], reach, dead_end_m)
    right, left = (np.array([point for points in rims[side] for point in points]) for side in (1.0, -1.0))
    loop = np.concatenate([right, left[::-1]])
    if strip.is_folded or outlines.crosses_itself(loop):
        hint = "give a greater straight_m, or a smaller half_width_m, corner_deg or dead_end_m"
        draws.unfit(keys.place("straight_m"), "the zigzag crosses itself", hint)
        return None
    return Corridor([wall(draws, keys, loop)], start(draws, keys), across(ends[-1], along[-1], half))


def _dead_end(corner: Doubles, along: Doubles, turn_rad: float, reach: float, length_m: float) -> list[Doubles]:
    """Return the points of a corridor's outer rim where it goes straight on past a corner, three of (2,)."""
    inner = math.copysign(reach, turn_rad) * np.array([-along[1], along[0]])
    begin_m = reach * (1 + math.cos(turn_rad)) / abs(math.sin(turn_rad))
    end = corner + (begin_m + length_m) * along
    return [end - inner, end + inner, corner + begin_m * along + inner]
