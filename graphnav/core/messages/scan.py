"""The message of a lidar: distances along beams in a plane."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Self

import graphnav_lcm
import numpy as np

from graphnav.arrays import Bools, Doubles, Floats
from graphnav.core.messages.message import FieldError, Message, may_be_infinite

_MAX_BEAMS = 100_000
_ROUNDING_RAD = 1e-3


class Scan(Message, lcm=graphnav_lcm.scan_t):
    """A scan of a lidar with a level plane of beams around the robot's centre, as ``sensor_msgs/LaserScan``.

    Beam k points to ``angle_min_rad + k * angle_increment_rad`` from forward, counterclockwise positive. ``ranges_m``:
    float32 (beams,), the distance to what a beam hits; infinite where it hits nothing up to ``range_max_m``. NaN, and
    distances below ``range_min_m`` or above ``range_max_m``, tell nothing.
    """

    angle_min_rad: float
    angle_increment_rad: float
    range_min_m: float
    range_max_m: float
    ranges_m: Floats = may_be_infinite()

    @classmethod
    def from_lcm_fields(cls, values: Mapping[str, Any]) -> Self:
        """Return the scan of ``scan_t``.

        Raises
        ------
        FieldError
            It has no beam or more than 100,000, its beams go round more than once or do not turn, or its distances
            are not 0 <= ``range_min_m`` < ``range_max_m``.
        """
        found = super().from_lcm_fields(values)
        if not 1 <= len(found.ranges_m) <= _MAX_BEAMS:
            raise FieldError("n_beams", len(found.ranges_m), f"1 to {_MAX_BEAMS}")
        around_rad = abs(found.angle_increment_rad) * (len(found.ranges_m) - 1)
        if found.angle_increment_rad == 0.0 or not around_rad <= 2 * math.pi + _ROUNDING_RAD:
            raise FieldError("angle_increment_rad", f"{found.angle_increment_rad:g}", "beams once around, not more")
        if not found.range_min_m >= 0.0:
            raise FieldError("range_min_m", f"{found.range_min_m:g}", "0 or more")
        if not found.range_max_m > found.range_min_m:
            raise FieldError("range_max_m", f"{found.range_max_m:g}", "more than range_min_m")
        return found

    def angles_rad(self) -> Doubles:
        """Return the direction of each beam from forward, (beams,)."""
        return np.asarray(self.angle_min_rad + self.angle_increment_rad * np.arange(len(self.ranges_m)))

    def hits(self) -> Bools:
        """Return which beams hit something at a distance that the lidar measures, (beams,)."""
        return np.asarray((self.ranges_m >= self.range_min_m) & (self.ranges_m <= self.range_max_m))

    def free_m(self) -> Doubles:
        """Return how far each beam passes through nothing, (beams,): 0 where it tells nothing."""
        passes = np.isposinf(self.ranges_m)
        return np.where(passes, self.range_max_m, np.where(self.hits(), self.ranges_m, 0.0)).astype(np.float64)

    def points_m(self) -> Doubles:
        """Return the points that were hit, in the robot's frame: x forward and y left, (hits, 2)."""
        hits = self.hits()
        angles, ranges_m = self.angles_rad()[hits], self.ranges_m[hits].astype(np.float64)
        return np.stack([ranges_m * np.cos(angles), ranges_m * np.sin(angles)], axis=1)
