"""Steering by the vector field histogram."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from graphnav import Goal, Latest, LocalMap, ParamError, Stage, Steering, param
from graphnav.arrays import Bools, Doubles
from graphnav_steer.headings import apart_rad, headed


class Polar(NamedTuple):
    """Cells around the robot: ``distance_m`` and ``bearing_rad`` in the map's frame, (2 reach + 1, 2 reach + 1)."""

    distance_m: Doubles
    bearing_rad: Doubles


class Vfh(Stage):
    """Vector field histogram [VFH]: heads for the valley of obstacle density nearest to the goal's bearing.

    Obstacles within ``active_m`` add a density to the sector that they are in, which falls with their distance, and to
    the sectors beside it by which a robot of this radius and margin would touch them. Sectors below ``max_density``
    form valleys. The robot heads for the middle of a narrow valley, and for the side of a wide one that is nearest to
    its goal: the beacon, or else straight ahead. Without a valley it turns on the spot. Unknown cells count as free:
    the method has no notion of them.

    References
    ----------
    .. [VFH] J. Borenstein, Y. Koren, The Vector Field Histogram, IEEE Trans. on Robotics and Automation 7(3), 1991.
    """

    robot_radius_m: float = param(0.2, gt=0.0, le=10.0, doc="radius of the robot's body")
    margin_m: float = param(0.05, ge=0.0, le=10.0, doc="distance to keep from obstacles beyond the radius")
    active_m: float = param(1.0, gt=0.0, le=20.0, doc="distance of the obstacles that count; more turns sooner")
    sectors: int = param(72, ge=8, le=720, doc="number of sectors around the robot")
    max_density: float = param(
        0.3,
        ge=0.0,
        le=1e6,
        doc="dimensionless: density of a sector that is still free; an obstacle's cell at contact has 1",
    )
    wide_deg: float = param(60.0, gt=0.0, le=360.0, doc="width from which a valley is wide")

    def check(self) -> None:
        """Check that obstacles count before the robot touches them."""
        kept_m = self.robot_radius_m + self.margin_m
        if self.active_m <= kept_m:
            what = f"'active_m' is {self.active_m:g}, but radius and margin of the robot are {kept_m:g}"
            raise ParamError("active_m", f"{what}: nothing counts before it is touched", "make it larger")

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Forget the side of the last turn."""
        self._spin = 1.0
        width = 2 * math.pi / self.sectors
        self._headings_rad = (np.arange(self.sectors) - self.sectors // 2) * width

    def step(self, map: LocalMap, goal: Latest[Goal]) -> Steering:  # noqa: A002  # the port's name
        """Return the steering towards the chosen valley: no repulsive force, a guiding force of length 1."""
        wanted_rad = 0.0 if goal.value is None else goal.value.bearing_rad
        theta_rad = self._theta_rad(self._density(map) <= self.max_density, wanted_rad)
        if theta_rad:
            self._spin = math.copysign(1.0, theta_rad)
        return headed(theta_rad)

    def _density(self, map: LocalMap) -> Doubles:  # noqa: A002
        """Return the largest density of each sector, (sectors,)."""
        reach = math.ceil(self.active_m / map.cell_m)
        (row,), (col,) = map.cells_at(np.zeros(1), np.zeros(1))
        around = np.pad(map.state, reach)[row : row + 2 * reach + 1, col : col + 2 * reach + 1]
        polar = _polar(reach, map.cell_m)
        there = (around >= LocalMap.OBSTACLE) & (polar.distance_m <= self.active_m)
        distance_m, bearing_rad = polar.distance_m[there], polar.bearing_rad[there] - map.yaw_rad
        kept_m = self.robot_radius_m + self.margin_m
        half_rad = np.arcsin(np.minimum(kept_m / np.maximum(distance_m, 1e-6), 1.0))
        beside_rad = apart_rad(np.asarray(self._headings_rad[:, None], np.float64), bearing_rad)
        density = np.clip((self.active_m - distance_m) / max(self.active_m - kept_m, 1e-6), 0.0, 1.0)
        return np.asarray(np.where(beside_rad <= half_rad, density, 0.0).max(axis=1, initial=0.0))

    def _theta_rad(self, free: Bools, wanted_rad: float) -> float:
        if free.all():
            return math.remainder(wanted_rad, 2 * math.pi)
        if not free.any():
            return self._spin * math.pi / 2
        first = int(np.argmin(free))
        turned = np.roll(free, -first)
        edges = np.diff(np.concatenate([[False], turned, [False]]).astype(np.int8))
        headings = [
            self._into(int(begin) + first, int(end) - 1 + first, wanted_rad)
            for begin, end in zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1), strict=True)
        ]
        return min(headings, key=lambda rad: abs(math.remainder(rad - wanted_rad, 2 * math.pi)))

    def _into(self, first: int, last: int, wanted_rad: float) -> float:
        """Return the heading into the valley of these sectors: its middle, or in a wide one the nearest safe one."""
        width_rad = 2 * math.pi / self.sectors
        begin_rad, end_rad = (self._headings_rad[0] + width_rad * sector for sector in (first, last))
        middle_rad, half_rad = (begin_rad + end_rad) / 2, (end_rad - begin_rad) / 2
        play_rad = max(half_rad - math.radians(self.wide_deg) / 2, 0.0)
        aside_rad = math.remainder(wanted_rad - middle_rad, 2 * math.pi)
        return math.remainder(middle_rad + min(max(aside_rad, -play_rad), play_rad), 2 * math.pi)


@lru_cache(maxsize=4)
def _polar(reach: int, cell_m: float) -> Polar:
    y, x = cell_m * np.mgrid[-reach : reach + 1, -reach : reach + 1]
    return Polar(np.hypot(x, y), np.arctan2(y, x))
