"""Headings: the steering at an angle without forces of obstacles, and the angle between two."""

from __future__ import annotations

import math

import numpy as np

from graphnav import Steering
from graphnav.arrays import Doubles
from graphnav_steer.axes import toward


def headed(theta_rad: float) -> Steering:
    """Return the steering at an angle from forward: a guiding force of length 1, no repulsive force."""
    along, nothing = toward(theta_rad), np.zeros(2)
    return Steering(repulsive=nothing, guiding=along, control=along, theta_rad=theta_rad, eigenvalues=nothing)


def apart_rad(headings_rad: Doubles, others_rad: Doubles | float) -> Doubles:
    """Return the angles between headings, 0 to pi; the arrays broadcast."""
    return np.asarray(np.abs(np.remainder(headings_rad - others_rad + math.pi, 2 * math.pi) - math.pi))
