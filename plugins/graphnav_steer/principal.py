"""Direction of a field of gradients: its first principal direction, or that of its mean."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np

from graphnav.arrays import Doubles

About = Literal["centroid", "zero"]

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
    mean = g.mean(axis=0)
    second = g.T @ g / len(g)
    nothing = NOTHING * math.sqrt(float(second[0, 0] + second[1, 1]))
    M = second - np.outer(mean, mean) if about == "centroid" else second
    v1, eigenvalues = _first_eigenvector(M)
    agreement = float(v1 @ mean)
    if eigenvalues[0] < isotropic_ratio * eigenvalues[1] or abs(agreement) <= nothing:
        return Principal(_direction(mean, nothing), eigenvalues)
    return Principal(v1 if agreement > 0 else -v1, eigenvalues)


def mean_direction(gradient: Doubles) -> Principal:
    """Return the direction of the mean gradient; there are no eigenvalues, both are zero.

    ``gradient``: (..., 2). Without a mean gradient there is none.
    """
    g = gradient.reshape(-1, 2)
    nothing = NOTHING * math.sqrt(float((g * g).sum()) / len(g))
    return Principal(_direction(g.mean(axis=0), nothing), np.zeros(2))


def _direction(vector: Doubles, nothing: float) -> Doubles | None:
    length = float(np.hypot(*vector))
    return vector / length if length > nothing else None


def _first_eigenvector(M: Doubles) -> tuple[Doubles, Doubles]:
    """Return the unit vector of the largest eigenvalue of a symmetric 2 x 2 matrix, and both eigenvalues."""
    a, b, c = float(M[0, 0]), float(M[0, 1]), float(M[1, 1])
    half, radius = (a + c) / 2, math.hypot((a - c) / 2, b)
    turn = 0.5 * math.atan2(2 * b, a - c)
    return np.array([math.cos(turn), math.sin(turn)]), np.array([half + radius, max(half - radius, 0.0)])
