"""Geman and McClure's estimator: weights of vectors in a fit that is robust against obstacles."""

from __future__ import annotations

from typing import TypeVar

import numpy as np

from graphnav.arrays import Doubles, Floats

Field = TypeVar("Field", Doubles, Floats)

NOISE_PX = 0.1
NOISE_DOC = (
    "flow noise: a vector that differs by this from the ground has a weight of a quarter, one of ten times as much none"
)


def agreement(squares_px2: Field, noise_px: float) -> Field:
    """Return the agreement of each vector with a fit, from 1 down to 0, (..., n).

    ``squares_px2``: (..., n), the squared lengths of the residuals. A residual of ``noise_px`` gets 1/2. The sum of the
    agreements is the maximized objective.
    """
    explained = squares_px2 * squares_px2.dtype.type(1 / noise_px**2)
    explained += 1
    np.reciprocal(explained, out=explained)
    return explained


def weights(squares_px2: Field, noise_px: float, counts: Field) -> Field:
    """Return each vector's weight in the next least-squares step, ``counts`` times its squared agreement, (n,)."""
    weight = squares_px2 * squares_px2.dtype.type(1 / noise_px**2)
    weight += 1
    weight *= weight
    np.divide(counts, weight, out=weight)
    return weight
