"""A small homography that is added to a flow, fitted robustly: what a rotation of the camera or a wrong scale adds.

References
----------
.. [HZ] R. Hartley, A. Zisserman, Multiple View Geometry in Computer Vision, 2004, section 8.1.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from graphnav.arrays import Doubles

_STEPS = (1.5, 1.0, 1.0, 1.0)
"""Flow noise assumed at each step, in units of the actual: the first one narrows from the start's."""

_RIDGE = 1e-6


class Fit(NamedTuple):
    """``factors``: (8,), of the fields. ``left_px``: (n, 2), what they leave. ``agreement``: (n,), from 1 down to 0."""

    factors: Doubles
    left_px: Doubles
    agreement: Doubles


@lru_cache(maxsize=16)
def small_homographies(rows: int, cols: int) -> Doubles:
    """Return the flows of the eight homographies near the identity, (8, rows * cols, 2).

    To first order they are shifts, linear maps and the two quadratic fields of a plane's motion [HZ]; in
    units in which the longer side of the picture reaches from -1 to 1.
    """
    y, x = (np.mgrid[:rows, :cols].reshape(2, -1) - np.array([[rows - 1], [cols - 1]]) / 2) / (max(rows, cols) / 2)
    one, zero = np.ones_like(x), np.zeros_like(x)
    along_x = np.stack([one, zero, x, y, zero, zero, x * x, x * y])
    along_y = np.stack([zero, one, zero, zero, x, y, x * y, y * y])
    fields = np.stack([along_x, along_y], axis=-1)
    fields.setflags(write=False)
    return fields


def agreement(left_px: Doubles, noise_px: float) -> Doubles:
    """Return how far vectors agree with a fit that leaves ``left_px`` (n, 2) of them: 1/2 at ``noise_px``."""
    return np.asarray(1 / (1 + np.einsum("ij,ij->i", left_px, left_px) / noise_px**2))


def fitted(fields: Doubles, vectors_px: Doubles, start: Doubles, noise_px: float) -> Fit:
    """Fit ``fields`` (8, n, 2) to ``vectors_px`` (n, 2) by reweighted least squares (Geman and McClure's estimator).

    ``start``: (n,), how far each vector agrees with what the fit starts from, from 1 down to 0.
    """
    columns, values = fields.reshape(len(fields), -1), vectors_px.reshape(-1)
    factors = _solved(columns, values, start)
    for step in _STEPS:
        left_px = (values - factors @ columns).reshape(-1, 2)
        factors = _solved(columns, values, agreement(left_px, step * noise_px))
    left_px = (values - factors @ columns).reshape(-1, 2)
    return Fit(factors, left_px, agreement(left_px, noise_px))


def _solved(columns: Doubles, values: Doubles, agreed: Doubles) -> Doubles:
    """Return the factors (8,) by weighted least squares; a small ridge keeps them finite on a line of vectors."""
    weighted = columns * np.repeat(agreed * agreed, 2)
    ridge = _RIDGE * len(agreed) * np.eye(len(columns))
    return np.asarray(np.linalg.solve(weighted @ columns.T + ridge, weighted @ values))
