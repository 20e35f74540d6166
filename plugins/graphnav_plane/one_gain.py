"""Dominant plane by the planar flow times one gain, fitted to the frame: the baseline of the separation."""

from __future__ import annotations

import numpy as np

from graphnav import param
from graphnav.arrays import Bools, Doubles, Floats
from graphnav_plane.agreement import median
from graphnav_plane.residual import Residual

_ITERATIONS = 10
_MIN_PX2 = 1e-12


class OneGain(Residual):
    """Obstacle is where the flow differs from a multiple of the planar flow: ``|u - a û|``.

    The baseline of `plane.ica`, whose obstacle component is such a difference too: it shows how much of the result is
    due to the one number a, and how much to the separation. The gain a is the same for the entire frame; it starts from
    the median over the cells (of how much of û each holds), then least squares are reweighted so that obstacles do not
    count (Geman and McClure's estimator). A robot at rest has no planar flow; its gain is 0.
    """

    noise_px: float = param(
        0.1,
        gt=0.0,
        le=100_000.0,
        doc="flow noise: a vector that differs by this from the ground has a weight of a quarter, one of ten times as "
        "much none",
    )

    def _ground_px(self, flow_px: Floats, planar_px: Floats, valid: Bools) -> Floats:
        """Return the multiple of the planar flow that most of the valid vectors agree with."""
        gain = robust_gain(flow_px[valid].astype(float), planar_px[valid].astype(float), self.noise_px)
        return np.float32(gain) * planar_px


def robust_gain(flow_px: Doubles, planar_px: Doubles, noise_px: float) -> float:
    """Return the multiple of ``planar_px`` (n, 2) with which most of ``flow_px`` (n, 2) agrees; 0 if all are zero."""
    flows, products, squares = (
        np.einsum("ij,ij->i", one, other)
        for one, other in ((flow_px, flow_px), (planar_px, flow_px), (planar_px, planar_px))
    )
    gain = float(median(products / np.maximum(squares, _MIN_PX2)))
    for _ in range(_ITERATIONS):
        left_px2 = flows - 2 * gain * products + gain * gain * squares
        weight = (1 + left_px2 / noise_px**2) ** -2
        gain = float(weight @ products) / max(float(weight @ squares), _MIN_PX2)
    return gain
