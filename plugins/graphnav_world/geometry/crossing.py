"""The path of an obstacle that waits for the robot and then crosses its way."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from graphnav.arrays import Doubles
from graphnav_world.geometry.patrol import Patrol

Pair = tuple[float, float]


@dataclass(frozen=True)
class Crossing:
    """A walk at constant speed through points, once, without turning; it avoids nothing.

    ``through_m``: float64 (n, 2), in W; it waits at the first. It sets out when the robot's centre is within
    ``within_m`` of that point, or when the robot, straight on at its present velocity, will have its centre on the line
    through the points within ``within_s``; None: not for that reason. ``returns``: whether it walks back as it came.
    """

    through_m: Doubles
    speed_mps: float
    within_m: float | None = None
    within_s: float | None = None
    returns: bool = False

    def at(self, walked_s: float) -> Pair:
        """Return the position (x, y) in W this long after it set out."""
        return self._walk.at(min(max(walked_s, 0.0), self._walk_s))

    def is_due(self, robot_m: Pair, velocity_mps: Pair) -> bool:
        """Return whether it sets out because of a robot whose centre is here and has this velocity, both in W."""
        if self.within_m is not None and math.dist(robot_m, self.through_m[0]) <= self.within_m:
            return True
        return self.within_s is not None and self._meets_in_s(robot_m, velocity_mps) <= self.within_s

    def _meets_in_s(self, robot_m: Pair, velocity_mps: Pair) -> float:
        """Return the time until the robot's centre is on the line; infinite if its way does not lead there."""
        (x, y), (vx, vy) = robot_m, velocity_mps
        soonest_s = math.inf
        for (from_x, from_y), (to_x, to_y) in itertools.pairwise(self.through_m.tolist()):
            along_x, along_y = to_x - from_x, to_y - from_y
            across = vx * along_y - vy * along_x
            if across == 0.0:
                continue
            time_s = ((from_x - x) * along_y - (from_y - y) * along_x) / across
            share = ((from_x - x) * vy - (from_y - y) * vx) / across
            if time_s >= 0.0 and 0.0 <= share <= 1.0:
                soonest_s = min(soonest_s, time_s)
        return soonest_s

    @cached_property
    def _walk(self) -> Patrol:
        return Patrol(self.through_m, self.speed_mps)

    @cached_property
    def _walk_s(self) -> float:
        length_m = float(np.linalg.norm(np.diff(self.through_m, axis=0), axis=1).sum())
        return (2 if self.returns else 1) * length_m / self.speed_mps
