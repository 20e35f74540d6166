"""The image's axes for forces: right and forward, where arrays count right and down."""

from __future__ import annotations

import math

import numpy as np

from graphnav.arrays import Doubles

AHEAD = np.array([0.0, 1.0])
"""Forward, the direction (0, 1) of [OI, eq. 10]."""
AHEAD.setflags(write=False)


def upright(right_down: Doubles) -> Doubles:
    """Return a vector of the array's axes (right, down) on the image's axes (right, forward).

    The only place where image rows, which grow downwards, are flipped.
    """
    return np.array([right_down[0], -right_down[1]])


def toward(bearing_rad: float) -> Doubles:
    """Return the unit vector (right, forward) at an angle from forward, left positive."""
    return np.array([-math.sin(bearing_rad), math.cos(bearing_rad)])


def angle_rad(force: Doubles) -> float:
    """Return the angle of a force (right, forward) from forward, left positive, in (-pi, pi].

    [OI, eq. 10] uses an arccosine, which loses the sign; the component to the right determines it.
    """
    return math.atan2(-float(force[0]), float(force[1]))
