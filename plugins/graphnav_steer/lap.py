"""A goal where a map has none: once around, to a place behind the robot that is cut off."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from graphnav import Map, State
from graphnav.arrays import Doubles

BEHIND_M = 0.8
"""How far behind the robot's centre the corridor is cut off."""
_DEPTHS = ((0.0, 0.1), (0.1, 0.7))
"""Where the wall and the goal begin and end, in metres further behind."""


def once_around(world: Map, state: State) -> Map:
    """Return the map with a wall across the corridor behind the robot, and a goal behind that wall.

    The corridor is between what stands; moving obstacles do not end it.

    Raises
    ------
    ValueError
        There is no wall on one of the two sides, so that there is no corridor to go around.
    """
    ahead = np.array([math.cos(state.yaw_rad), math.sin(state.yaw_rad)])
    left = np.array([-ahead[1], ahead[0]])
    behind = np.array([state.x_m, state.y_m]) - BEHIND_M * ahead
    left_m, right_m = _free_m(world, behind, left), _free_m(world, behind, -left)
    if not math.isfinite(left_m + right_m):
        raise ValueError("the map has no goal to plan a way to, and no corridor to go around: use a map with a goal")
    rim = np.array([behind - right_m * left, behind + left_m * left])
    cut, goal = (np.concatenate([rim - near * ahead, rim[::-1] - far * ahead]) for near, far in _DEPTHS)
    return replace(
        world,
        kind=np.append(world.kind, np.uint8(Map.WALL)),
        height_m=np.append(world.height_m, 1.0),
        vertices_m=np.concatenate([world.vertices_m, cut]),
        body=np.append(world.body, np.full(len(cut), len(world.kind))).astype(np.int32),
        goal_m=goal,
    )


def _free_m(world: Map, here: Doubles, along: Doubles) -> float:
    """Return the distance to the nearest outline of what stands in a direction, infinite if there is none."""
    stands = world.kind[world.body] != Map.MOVING
    begin, end = world.vertices_m[stands], world.vertices_m[world.next_vertices()[stands]]
    side, across = end - begin, np.array([-along[1], along[0]])
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (here - begin) @ across / (side @ across)
        distance_m = (begin + share[:, None] * side - here) @ along
    hit = (share >= 0) & (share <= 1) & (distance_m > 0)
    return float(distance_m[hit].min(initial=math.inf))
