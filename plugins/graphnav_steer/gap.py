"""Steering to the gap: the free way nearest to where the robot wants to go."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from graphnav import Goal, Latest, LocalMap, ParamError, Stage, Steering, param
from graphnav.arrays import Doubles
from graphnav_steer.headings import headed
from graphnav_steer.longest_way import Costs, LongestWay


class Gap(Stage):
    """Heads for the gap: the heading with the longest free way, less the cost of turning there.

    For each heading the free way of a disc is as long as nothing on the map is nearer to its middle than the robot's
    radius and a margin. The heading with the maximum length, less costs for turning, for changing the last choice and
    for leaving the goal's bearing, wins. Where no way is free for ``min_way_m``, the robot turns on the spot, to the
    side of the best one, and goes on to the side that it has begun with.

    References
    ----------
    .. [VFH] J. Borenstein, Y. Koren, The Vector Field Histogram, IEEE Trans. on Robotics and Automation 7(3), 1991.
    .. [ND] J. Minguez, L. Montano, Nearness Diagram Navigation, IEEE Trans. on Robotics and Automation 20(1), 2004.
    """

    robot_radius_m: float = param(0.2, gt=0.0, le=10.0, doc="radius of the robot's body")
    margin_m: float = param(0.03, ge=0.0, le=10.0, doc="distance to keep from obstacles beyond the radius")
    unknown: Literal["obstacle", "free"] = param(
        "obstacle", doc="what cells that were never judged count as; free drives where nothing was seen"
    )
    max_way_m: float = param(1.0, gt=0.0, le=100.0, doc="a longer free way counts as this long")
    min_way_m: float = param(
        0.1, ge=0.0, le=100_000.0, doc="with no heading free for this long the robot turns on the spot"
    )
    turn_cost_m: float = param(0.25, ge=0.0, le=100_000.0, doc="cost of turning by half a circle")
    change_cost_m: float = param(
        0.3, ge=0.0, le=100_000.0, doc="cost of a heading at half a circle from the last choice"
    )
    goal_cost_m: float = param(1.5, ge=0.0, le=100_000.0, doc="cost of a heading at half a circle from the goal")
    headings: int = param(72, ge=8, le=720, doc="number of headings around the robot")

    def check(self) -> None:
        """Check that a way can be as long as the robot wants it."""
        if self.min_way_m > self.max_way_m:
            what = f"'min_way_m' {self.min_way_m:g} is more than 'max_way_m' {self.max_way_m:g}"
            raise ParamError("min_way_m", f"{what}: the robot would only turn", "make it less")

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Forget the last choice."""
        half = np.arange(self.headings) - self.headings // 2
        self._headings_rad = half * 2 * math.pi / self.headings
        costs = Costs(self.turn_cost_m, self.change_cost_m, self.goal_cost_m)
        self._longest = LongestWay(self._headings_rad, self.min_way_m, costs)

    def step(self, map: LocalMap, goal: Latest[Goal]) -> Steering:  # noqa: A002  # the port's name
        """Return the steering towards the chosen heading: no repulsive force, a guiding force of length 1."""
        way_m = np.minimum(self._ways_m(map), self.max_way_m)
        goal_rad = None if goal.value is None else goal.value.bearing_rad
        return headed(self._longest.theta_rad(way_m, goal_rad, map.yaw_rad))

    def _ways_m(self, map: LocalMap) -> Doubles:  # noqa: A002
        """Return the free way of each heading, (headings,)."""
        steps_m = map.cell_m / 2 * np.arange(0, math.ceil(2 * self.max_way_m / map.cell_m) + 1)
        ways = [np.outer(f(self._headings_rad), steps_m) for f in (np.cos, np.sin)]
        clearance_m = map.obstacle_m_at(ways[0], ways[1])
        free = clearance_m >= np.minimum(self.robot_radius_m + self.margin_m, clearance_m[:, :1] - map.cell_m / 8)
        if self.unknown == "obstacle":
            free &= map.unknown_m_at(ways[0], ways[1]) > 0.0
        free[:, 0] = True
        return np.asarray(map.cell_m / 2 * (np.logical_and.accumulate(free, axis=1).sum(axis=1) - 1.0))
