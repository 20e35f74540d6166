"""Direction of a field of gradients: its first principal direction, or that of its mean."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import cv2
import numpy as np

from graphnav.arrays import Doubles

About = Literal["centroid", "zero"]
Pair = tuple[float, float]

NOTHING = 1e-6
"""Zero threshold, relative to the gradients' root mean square."""


class Principal(NamedTuple):
    """``direction``: unit vector (2,) to the obstacle, None if there is none. ``eigenvalues``: (2,), largest first."""

    direction: Doubles | None
    eigenvalues: Doubles


def principal_direction(gradient: Doubles, about: About, isotropic_ratio: float) -> Principal:
    """Return v1 of [OI, eq. 7], signed to agree with the mean gradient.

    ``gradient``: (..., 2). ``about``: whether M is the covariance ("centroid", as eq. 7 has it) or the second moment
    ("zero"). Where v1 is arbitrary, because lambda1 < ``isotropic_ratio`` * lambda2, or where the mean gradient gives
    it no sign, the direction is the mean gradient's own. Without a mean gradient either there is none: obstacles
    everywhere, or nowhere.
    """
    g = gradient.reshape(-1, 2)
    x, y = mean = mean_gradient(g)
    (xx, xy), (_, yy) = (g.T @ g / len(g)).tolist()
    nothing = NOTHING * math.sqrt(xx + yy)
    if about == "centroid":
        xx, xy, yy = xx - x * x, xy - x * y, yy - y * y
    (v1_x, v1_y), (first, second) = _first_eigenvector(xx, xy, yy)
    agreement = v1_x * x + v1_y * y
    eigenvalues = np.array([first, second])
    if first < isotropic_ratio * second or abs(agreement) <= nothing:
        return Principal(_direction(mean, nothing), eigenvalues)
    return Principal(np.array([v1_x, v1_y]) * math.copysign(1.0, agreement), eigenvalues)


def mean_direction(gradient: Doubles) -> Principal:
    """Return the direction of the mean gradient; there are no eigenvalues, both are zero.

    ``gradient``: (..., 2). Without a mean gradient there is none.
    """
    g = gradient.reshape(-1, 2)
    nothing = NOTHING * math.sqrt(float(np.vdot(g, g)) / len(g))
    return Principal(_direction(mean_gradient(g), nothing), np.zeros(2))


def mean_gradient(gradient: Doubles) -> Pair:
    """Return the mean of gradients (..., 2), right and down; ten times as fast as numpy's."""
    x, y, *_ = cv2.mean(gradient.reshape(-1, 1, 2))
    return x, y


def _direction(vector: Pair, nothing: float) -> Doubles | None:
    length = math.hypot(*vector)
    return np.array(vector) / length if length > nothing else None


def _first_eigenvector(a: float, b: float, c: float) -> tuple[Pair, Pair]:
    """Return the unit vector of the largest eigenvalue of ((a, b), (b, c)), and both eigenvalues."""
    half, radius = (a + c) / 2, math.hypot((a - c) / 2, b)
    turn = 0.5 * math.atan2(2 * b, a - c)
    return (math.cos(turn), math.sin(turn)), (half + radius, max(half - radius, 0.0))
