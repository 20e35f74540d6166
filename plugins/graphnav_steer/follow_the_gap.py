"""Steering by a lidar alone: into the widest gap between what it sees."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from graphnav import Goal, Latest, Scan, Stage, Steering, param
from graphnav.arrays import Bools, Doubles, Indices
from graphnav_steer.headings import apart_rad, headed

_MIN_RANGE_M = 1e-3


class _Grown(NamedTuple):
    """Obstacles that a robot without extent must not meet: the range of each, its first and its last beam, (n,).

    The beams may lie outside of the scan.
    """

    range_m: Doubles
    first: Indices
    last: Indices

    def covered(self, beams: int) -> Bools:
        """Return which beams meet one, (beams,)."""
        edges = np.bincount(np.clip(self.first, 0, beams), minlength=beams + 1)
        edges -= np.bincount(np.clip(self.last + 1, 0, beams), minlength=beams + 1)
        return np.asarray(np.cumsum(edges)[:beams] > 0)

    def nearest_m(self, beam: int, horizon_m: float) -> float:
        """Return the range of the nearest one that a beam meets, the horizon if it meets none."""
        return float(self.range_m[(self.first <= beam) & (beam <= self.last)].min(initial=horizon_m))


class _Gap(NamedTuple):
    """A run of free beams, the first and the last of them."""

    first: int
    last: int


class FollowTheGap(Stage):
    """Follow the gap [FGM]: heads for a mean of the goal's bearing and the middle of the widest gap.

    What the lidar sees within ``horizon_m`` is an obstacle, grown by the robot's radius and ``margin_m``, so that the
    robot is a point. The widest run of beams that meet none is the gap; its middle lies midway between the obstacles at
    its two borders. The heading is the mean of both angles, the gap's with the weight ``gap_weight_m`` over the
    distance of the nearest obstacle, the goal's with the weight 1: an obstacle that is near makes it safe. Without a
    goal the robot heads for the gap's middle.

    It keeps no map: it does not leave a dead end, and a wide gap that leads back attracts it. Without a gap it
    turns on the spot, to the side that it turned to before.

    References
    ----------
    .. [FGM] V. Sezer, M. Gokasan, A Novel Obstacle Avoidance Algorithm: "Follow the Gap Method", Robotics and
       Autonomous Systems 60(9), 2012: eq. 8 to 10 the gap's middle, eq. 11 the heading.
    """

    robot_radius_m: float = param(0.2, gt=0.0, le=10.0, doc="radius of the robot's body")
    margin_m: float = param(0.05, ge=0.0, le=10.0, doc="distance to keep from obstacles beyond the radius")
    horizon_m: float = param(
        2.0,
        gt=0.0,
        le=1000.0,
        doc="distance beyond which what the lidar sees is not an obstacle; more sees dead ends sooner",
    )
    window_deg: float = param(
        180.0, ge=10.0, le=360.0, doc="field of view in which gaps are looked for, half to either side of forward"
    )
    goal_cost: float = param(
        1.0,
        ge=0.0,
        le=1000.0,
        doc="dimensionless: radians of width that a gap loses for each radian between its middle and the goal; "
        "0 chooses the widest, as [FGM]",
    )
    gap_weight_m: float = param(
        1.0,
        ge=0.0,
        le=1000.0,
        doc="distance of the nearest obstacle at which gap and goal weigh the same (alpha of [FGM]); more is safer and "
        "leads farther around",
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Forget the side of the last turn."""
        self._side = 1.0

    def step(self, scan: Scan, goal: Latest[Goal]) -> Steering:
        """Return the steering at the heading: no repulsive force, a guiding force of length 1."""
        theta_rad = self._theta_rad(scan, None if goal.value is None else goal.value.bearing_rad)
        if theta_rad:
            self._side = math.copysign(1.0, theta_rad)
        return headed(theta_rad)

    def _theta_rad(self, scan: Scan, goal_rad: float | None) -> float:
        grown, angles_rad = self._grown(scan), scan.angles_rad()
        free = (scan.free_m() > 0.0) & (np.abs(angles_rad) <= math.radians(self.window_deg) / 2)
        gaps = _runs(free & ~grown.covered(len(angles_rad)))
        if not gaps:
            return self._side * math.pi / 2
        middles_rad = np.array([self._middle_rad(angles_rad, grown, gap) for gap in gaps])
        widths_rad = np.array([abs(angles_rad[gap.last] - angles_rad[gap.first]) for gap in gaps])
        if goal_rad is None:
            return float(middles_rad[np.argmax(widths_rad)])
        best = np.argmax(widths_rad - self.goal_cost * apart_rad(middles_rad, goal_rad))
        if not len(grown.range_m):
            return goal_rad
        weight = self.gap_weight_m / max(float(grown.range_m.min()), _MIN_RANGE_M)
        return (weight * float(middles_rad[best]) + goal_rad) / (weight + 1.0)

    def _grown(self, scan: Scan) -> _Grown:
        at = np.flatnonzero(scan.hits() & (scan.ranges_m <= self.horizon_m))
        range_m = scan.ranges_m[at].astype(np.float64)
        ratio = (self.robot_radius_m + self.margin_m) / np.maximum(range_m, _MIN_RANGE_M)
        half = (np.arcsin(np.minimum(ratio, 1.0)) / abs(scan.angle_increment_rad)).astype(np.intp)
        return _Grown(range_m, at - half, at + half)

    def _middle_rad(self, angles_rad: Doubles, grown: _Grown, gap: _Gap) -> float:
        """Return the direction of the point midway between the borders of a gap; of half a circle, its middle angle.

        A border is as far away as the nearest obstacle that closes the gap there, at most the horizon.
        """
        first_rad, last_rad = float(angles_rad[gap.first]), float(angles_rad[gap.last])
        if abs(last_rad - first_rad) >= math.pi:
            return (first_rad + last_rad) / 2
        first_m = grown.nearest_m(gap.first - 1, self.horizon_m)
        last_m = grown.nearest_m(gap.last + 1, self.horizon_m)
        x = first_m * math.cos(first_rad) + last_m * math.cos(last_rad)
        y = first_m * math.sin(first_rad) + last_m * math.sin(last_rad)
        return math.atan2(y, x)


def _runs(free: Bools) -> list[_Gap]:
    """Return all runs of ``free`` beams."""
    edges = np.diff(np.concatenate([[0], free.view(np.int8), [0]]))
    begins, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    return [_Gap(int(begin), int(end) - 1) for begin, end in zip(begins, ends, strict=True)]
