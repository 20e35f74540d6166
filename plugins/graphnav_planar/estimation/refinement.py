"""Correct the motion from odometry by the flow."""

from __future__ import annotations

import numpy as np

from graphnav.arrays import Floats
from graphnav_planar.estimation.robust import NOISE_PX

_ITERATIONS = 3
_RIDGE = 1e-6 / NOISE_PX**2
"""In units of the squared flow noise."""


def correction(fields_px: Floats, counts: Floats, max_share: float) -> tuple[float, float]:
    """Return the relative corrections of the forward displacement and the turn.

    ``fields_px``: (3, 2n), flow minus planar flow, and the derivative of the planar flow by each correction; u
    and v of each vector in turn. ``counts``: (n,), 1 for a vector to fit, 0 for others. ``max_share``:
    limit of the corrections.

    Least squares, three times reweighted: a vector that differs by much more than flow noise, an obstacle's, has no
    weight (Geman and McClure's). It starts from odometry, so obstacles may cover more than the floor; the limit keeps
    the fit from following them.
    """
    products = _products(fields_px)
    # One plus the square of what the corrections s leave of a difference d: 1 + d.d - 2 s_i r_i.d + s_i s_j r_i.r_j.
    products[0] += 1
    forward, turn = 0.0, 0.0
    for _ in range(_ITERATIONS):
        of_products = [1.0, -2 * forward, -2 * turn, forward * forward, 2 * forward * turn, turn * turn]
        weight = np.array(of_products, np.float32) @ products
        weight *= weight
        np.divide(counts, weight, out=weight)
        _, vd, wd, vv, vw, ww = (products @ weight).tolist()
        vv, ww = vv + _RIDGE, ww + _RIDGE
        determinant = vv * ww - vw * vw
        forward = min(max((ww * vd - vw * wd) / determinant, -max_share), max_share)
        turn = min(max((vv * wd - vw * vd) / determinant, -max_share), max_share)
    return forward, turn


def _products(fields_px: Floats) -> Floats:
    """Return the products d.d, v.d, w.d, v.v, v.w and w.w of every vector of the fields d, v and w, (6, n).

    In units of the flow noise: a square of 1 is that of a vector that has half of its agreement.
    """
    fields_px = fields_px * np.float32(1 / NOISE_PX)
    products = np.empty((6, fields_px.shape[1]), np.float32)
    np.multiply(fields_px, fields_px[0], out=products[:3])
    np.multiply(fields_px[1:], fields_px[1], out=products[3:5])
    np.multiply(fields_px[2], fields_px[2], out=products[5])
    return np.add(products[:, ::2], products[:, 1::2])
