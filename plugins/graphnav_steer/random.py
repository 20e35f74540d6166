"""Random headings: a baseline that has to fail."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from graphnav import Plane, Stage, Stamp, Steering, param
from graphnav_steer.headings import headed


class Random(Stage):
    """Headings drawn at random, each held for a random time, regardless of obstacles.

    A baseline: a method that is not better than this one detects nothing.
    """

    role: ClassVar = "baseline"

    widest_deg: float = param(
        90.0, gt=0.0, le=180.0, doc="headings are drawn uniformly up to this angle to either side"
    )
    hold_s: float = param(1.0, gt=0.0, le=1e6, doc="mean time for which a heading is held; times are exponential")

    def reset(self, seed: int) -> None:
        """Start the draws of this seed."""
        self._rng = np.random.default_rng(seed)
        self._theta_rad = 0.0
        self._next_us: int | None = None

    def step(self, plane: Plane, stamp: Stamp) -> Steering:  # noqa: ARG002  # the plane only says when to steer
        """Return no repulsive force and a guiding force along the heading."""
        if self._next_us is None or stamp >= self._next_us:
            self._theta_rad = math.radians(self._rng.uniform(-self.widest_deg, self.widest_deg))
            self._next_us = stamp + round(1e6 * self._rng.exponential(self.hold_s))
        return headed(self._theta_rad)
