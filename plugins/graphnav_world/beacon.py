"""A beacon that errs."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from graphnav import Goal


@dataclass(frozen=True)
class BeaconErrors:
    """Errors of a run: a constant bias of the bearing and scale of the distance, and new noise of every bearing.

    ``rng`` draws the noise. ``bias_rad``: counterclockwise. ``distance_scale``: 1 is exact.
    """

    rng: np.random.Generator
    sigma_rad: float
    bias_rad: float
    distance_scale: float

    def read(self, bearing_rad: float, distance_m: float) -> Goal:
        """Return what the beacon tells of the true bearing and distance."""
        error_rad = self.bias_rad
        if self.sigma_rad:
            error_rad += self.sigma_rad * float(self.rng.standard_normal())
        if error_rad:
            bearing_rad = math.remainder(bearing_rad + error_rad, 2 * math.pi)
        return Goal(bearing_rad=bearing_rad, distance_m=distance_m * self.distance_scale)
