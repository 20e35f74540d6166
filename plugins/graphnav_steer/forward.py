"""Straight ahead, regardless of obstacles: a baseline that has to fail."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from graphnav import Plane, Stage, Steering
from graphnav_steer.axes import AHEAD


class Forward(Stage):
    """Always straight ahead.

    A baseline: worlds in which this stage succeeds test nothing.
    """

    role: ClassVar = "baseline"

    def step(self, plane: Plane) -> Steering:  # noqa: ARG002  # the plane only says when to steer
        """Return no repulsive force and the guiding force (0, 1)."""
        nothing = np.zeros(2)
        return Steering(repulsive=nothing, guiding=AHEAD, control=AHEAD, theta_rad=0.0, eigenvalues=nothing)
