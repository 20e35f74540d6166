"""The choice of the heading with the longest free way."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from graphnav.arrays import Doubles
from graphnav_steer.headings import apart_rad


class Costs(NamedTuple):
    """Costs of a heading at half a circle from forward, from the last choice, and from the goal, in units of ways."""

    turn: float
    change: float
    goal: float


class LongestWay:
    """Chooses the heading whose free way less its costs is longest.

    Where no way is as long as ``min_way``, it is a right angle to the side of the best one, and stays on the side that
    it has begun with.
    """

    def __init__(self, headings_rad: Doubles, min_way: float, costs: Costs) -> None:
        self._headings_rad, self._min_way, self._costs = headings_rad, min_way, costs
        self._chosen_rad: float | None = None
        self._spin = 0.0

    def theta_rad(self, ways: Doubles, goal_rad: float | None, yaw_rad: float = 0.0) -> float:
        """Return the chosen heading, from the free way of each; ``yaw_rad``: by which the robot has turned so far."""
        found = self._choice(ways, self._costs_of(goal_rad, yaw_rad))
        self._chosen_rad = found + yaw_rad
        return found

    def _costs_of(self, goal_rad: float | None, yaw_rad: float) -> Doubles:
        cost = self._costs.turn * self._half_circles(0.0)
        if self._chosen_rad is not None:
            cost += self._costs.change * self._half_circles(self._chosen_rad - yaw_rad)
        if goal_rad is not None:
            cost += self._costs.goal * self._half_circles(goal_rad)
        return cost

    def _choice(self, ways: Doubles, cost: Doubles) -> float:
        best = int(np.argmax(ways - cost))
        if ways[best] >= self._min_way:
            self._spin = 0.0
            return float(self._headings_rad[best])
        if not self._spin:
            self._spin = math.copysign(1.0, float(self._headings_rad[best]))
        return self._spin * math.pi / 2

    def _half_circles(self, other_rad: float) -> Doubles:
        """Return the angles between the headings and another one, as shares of half a circle."""
        return apart_rad(self._headings_rad, other_rad) / math.pi
