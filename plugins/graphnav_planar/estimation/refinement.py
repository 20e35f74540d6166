"""Correct the motion from odometry by the flow."""

from __future__ import annotations

import numpy as np

from graphnav.arrays import Doubles
from graphnav_planar.estimation.robust import NOISE_PX, agreement

_ITERATIONS = 3
_RIDGE_PX2 = 1e-6


def correction(rates_px: Doubles, difference_px: Doubles, max_share: float) -> Doubles:
    """Return the relative corrections of the forward displacement and the turn, (2,).

    ``rates_px``: (2, 2n), derivative of the planar flow by each correction: n horizontal parts, then the vertical ones.
    ``difference_px``: (2n,), flow minus planar flow, likewise. ``max_share``: limit of the corrections.

    Least squares, three times reweighted: a vector that differs by much more than flow noise, an obstacle's, has no
    weight (Geman and McClure's). It starts from odometry, so obstacles may cover more than the floor; the limit keeps
    the fit from following them.
    """
    shares = np.zeros(2)
    for _ in range(_ITERATIONS):
        explained = agreement(difference_px - shares @ rates_px, NOISE_PX)
        weighted = rates_px * np.tile(explained * explained, 2)
        products = weighted @ rates_px.T + _RIDGE_PX2 * np.eye(2)
        shares = np.clip(np.linalg.solve(products, weighted @ difference_px), -max_share, max_share)
    return shares
