"""Steering by the vector field histogram, VFH+."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from graphnav import Goal, Latest, LocalMap, Motion, ParamError, Stage, Steering, param
from graphnav.arrays import Bools, Doubles
from graphnav_steer.headings import apart_rad, headed
from graphnav_steer.speed_window import measured_speeds


class _Polar(NamedTuple):
    """Cells around the robot: distance, and bearing in the map's frame, any shape."""

    distance_m: Doubles
    bearing_rad: Doubles


class Vfh(Stage):
    """Vector field histogram, VFH+ [VFH+]: heads for the opening among obstacles that costs least.

    - **Primary histogram.** Every obstacle's cell within ``active_m`` adds a density, 1 at the robot's place and 0 at
      ``active_m``, to the sectors in which a robot of this radius and margin would touch it.
    - **Binary histogram.** A sector is blocked above ``max_density`` and free below ``min_density``; between the two it
      stays as it was.
    - **Masked histogram.** Free sectors to a side are blocked, too, where the circle that the robot drives at least at
      its speed, of radius ``v / max_turn_radps``, meets an obstacle before them.
    - **Choice.** Candidates are the middle of a narrow opening; of a wide one both sides, and the goal's bearing if it
      is inside. The candidate of the lowest cost wins: what it differs from the goal's bearing, from forward, and from
      the last choice. Without a goal the wanted direction is straight ahead.

    Without an opening it turns on the spot. Unknown cells count as free: the method has no notion of them. The speed is
    that of the ``control`` stage.

    References
    ----------
    .. [VFH+] I. Ulrich, J. Borenstein, VFH+: Reliable Obstacle Avoidance for Fast Mobile Robots, IEEE International
       Conference on Robotics and Automation, 1998, which extends
    .. [VFH] J. Borenstein, Y. Koren, The Vector Field Histogram, IEEE Trans. on Robotics and Automation 7(3), 1991.
    """

    robot_radius_m: float = param(0.2, gt=0.0, le=10.0, doc="radius of the robot's body")
    margin_m: float = param(0.05, ge=0.0, le=10.0, doc="distance to keep from obstacles beyond the radius")
    max_turn_radps: float = param(
        1.2, gt=0.0, le=1000.0, doc="maximum turning rate, which with the speed makes the turning circle"
    )
    active_m: float = param(1.0, gt=0.0, le=20.0, doc="distance of the obstacles that count; more turns sooner")
    sectors: int = param(72, ge=8, le=720, doc="number of sectors around the robot")
    max_density: float = param(
        2.0,
        ge=0.0,
        le=1e6,
        doc="dimensionless: density above which a sector is blocked (tau_high), in obstacle cells at the robot's place",
    )
    min_density: float = param(
        1.0, ge=0.0, le=1e6, doc="dimensionless: density below which a blocked sector is free again (tau_low)"
    )
    wide_deg: float = param(60.0, gt=0.0, le=360.0, doc="width from which an opening is wide (s_max)")
    goal_cost: float = param(
        5.0, ge=0.0, le=1000.0, doc="dimensionless: cost of a radian beside the goal's bearing (mu_1)"
    )
    turn_cost: float = param(2.0, ge=0.0, le=1000.0, doc="dimensionless: cost of a radian to turn (mu_2)")
    change_cost: float = param(
        2.0, ge=0.0, le=1000.0, doc="dimensionless: cost of a radian beside the last choice (mu_3)"
    )

    def check(self) -> None:
        """Check that obstacles count before the robot touches them, and that the thresholds are in order."""
        kept_m = self._kept_m()
        if self.active_m <= kept_m:
            what = f"'active_m' is {self.active_m:g}, but radius and margin of the robot are {kept_m:g}"
            raise ParamError("active_m", f"{what}: nothing counts before it is touched", "make it larger")
        if self.min_density > self.max_density:
            what = f"'min_density' {self.min_density:g} is more than 'max_density' {self.max_density:g}"
            raise ParamError("min_density", f"{what}: a sector would be blocked and free", "make it less")

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Forget which sectors were blocked, and the last choice."""
        self._spin = 1.0
        self._chosen_rad: float | None = None
        self._blocked = np.zeros(self.sectors, np.bool_)
        self._width_rad = 2 * math.pi / self.sectors
        self._headings_rad = (np.arange(self.sectors) - self.sectors // 2) * self._width_rad

    def step(self, map: LocalMap, goal: Latest[Goal], motion: Latest[Motion]) -> Steering:  # noqa: A002  # the port's name
        """Return the steering towards the chosen direction: no repulsive force, a guiding force of length 1."""
        near = self._near(map)
        density = self._density(near)
        self._blocked = (density > self.max_density) | (self._blocked & (density >= self.min_density))
        speed_mps = max(measured_speeds(motion.value)[0], 0.0)
        free = ~self._blocked & self._reached(near, map.yaw_rad, speed_mps / self.max_turn_radps)
        wanted_rad = map.yaw_rad + (0.0 if goal.value is None else goal.value.bearing_rad)
        return headed(self._theta_rad(free, wanted_rad, map.yaw_rad))

    def _kept_m(self) -> float:
        return self.robot_radius_m + self.margin_m

    def _near(self, map: LocalMap) -> _Polar:  # noqa: A002
        """Return the obstacles' cells within ``active_m``, (n,)."""
        reach = math.ceil(self.active_m / map.cell_m)
        (row,), (col,) = map.cells_at(np.zeros(1), np.zeros(1))
        around = np.pad(map.state, reach)[row : row + 2 * reach + 1, col : col + 2 * reach + 1]
        polar = _polar(reach, map.cell_m)
        there = (around >= LocalMap.OBSTACLE) & (polar.distance_m <= self.active_m)
        return _Polar(polar.distance_m[there], polar.bearing_rad[there])

    def _density(self, near: _Polar) -> Doubles:
        """Return the primary histogram, (sectors,)."""
        half_rad = np.arcsin(np.minimum(self._kept_m() / np.maximum(near.distance_m, 1e-6), 1.0))
        beside_rad = apart_rad(np.asarray(self._headings_rad[:, None], np.float64), near.bearing_rad)
        density = 1.0 - (near.distance_m / self.active_m) ** 2
        return np.asarray(np.where(beside_rad <= half_rad, density, 0.0).sum(axis=1))

    def _reached(self, near: _Polar, yaw_rad: float, radius_m: float) -> Bools:
        """Return the sectors to which a circle of this radius leads past what is near, (sectors,).

        What is nearer than radius and margin already does not count: the robot can turn on the spot.
        """
        kept_m = self._kept_m()
        left_rad = np.remainder(near.bearing_rad - yaw_rad + math.pi, 2 * math.pi) - math.pi
        x_m, y_m = near.distance_m * np.cos(left_rad), near.distance_m * np.sin(left_rad)
        ahead_rad = np.remainder(self._headings_rad - yaw_rad + math.pi, 2 * math.pi) - math.pi
        reached = np.ones(self.sectors, np.bool_)
        for side in (1.0, -1.0):
            meets = (np.hypot(x_m, y_m - side * radius_m) < radius_m + kept_m) & (near.distance_m > kept_m)
            reached &= side * ahead_rad <= (side * left_rad)[meets & (side * left_rad > 0.0)].min(initial=math.pi)
        return reached

    def _theta_rad(self, free: Bools, wanted_rad: float, yaw_rad: float) -> float:
        """Return the chosen direction, from forward."""
        found = list(self._candidates(free, wanted_rad))
        if not found:
            return self._spin * math.pi / 2
        self._chosen_rad = min(found, key=lambda rad: self._cost(rad, wanted_rad, yaw_rad))
        theta_rad = math.remainder(self._chosen_rad - yaw_rad, 2 * math.pi)
        if theta_rad:
            self._spin = math.copysign(1.0, theta_rad)
        return theta_rad

    def _cost(self, rad: float, wanted_rad: float, yaw_rad: float) -> float:
        last_rad = yaw_rad if self._chosen_rad is None else self._chosen_rad
        parts = ((self.goal_cost, wanted_rad), (self.turn_cost, yaw_rad), (self.change_cost, last_rad))
        return sum(cost * abs(math.remainder(rad - other_rad, 2 * math.pi)) for cost, other_rad in parts)

    def _candidates(self, free: Bools, wanted_rad: float) -> Iterator[float]:
        """Yield the directions to choose from, in the map's frame."""
        if free.all():
            yield wanted_rad
            return
        first = int(np.argmin(free))
        edges = np.diff(np.concatenate([[False], np.roll(free, -first), [False]]).astype(np.int8))
        for begin, end in zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1), strict=True):
            begin_rad, end_rad = (
                float(self._headings_rad[0] + self._width_rad * (sector + first)) for sector in (begin, end - 1)
            )
            yield from self._into(begin_rad, end_rad, wanted_rad)

    def _into(self, begin_rad: float, end_rad: float, wanted_rad: float) -> Iterator[float]:
        """Yield the candidates of an opening between the middles of its first and its last sector."""
        middle_rad, play_rad = (begin_rad + end_rad) / 2, (end_rad - begin_rad - math.radians(self.wide_deg)) / 2
        if play_rad <= 0.0:
            yield middle_rad
            return
        yield middle_rad - play_rad
        yield middle_rad + play_rad
        aside_rad = math.remainder(wanted_rad - middle_rad, 2 * math.pi)
        if abs(aside_rad) < play_rad:
            yield middle_rad + aside_rad


@lru_cache(maxsize=4)
def _polar(reach: int, cell_m: float) -> _Polar:
    y, x = cell_m * np.mgrid[-reach : reach + 1, -reach : reach + 1]
    return _Polar(np.hypot(x, y), np.arctan2(y, x))
