"""Fit free factors to the flow of a frame, with forward displacement and turn near odometry."""

from __future__ import annotations

import numpy as np

from graphnav.arrays import Doubles
from graphnav_planar.estimation.egomotion import FREE_NOISE_FACTORS
from graphnav_planar.estimation.robust import NOISE_PX, weights
from graphnav_planar.estimation.series import Series


def bounded_motion(series: Series, products: Doubles, counts: Doubles, odometry: Doubles, max_share: float) -> Doubles:
    """Return the motion with which most of the flow agrees, (unknowns,), from a start at ``odometry`` (2,).

    ``products``: (products, n), of ``series``; ``counts``: (n,), 1 for a vector to fit, 0 for others. ``max_share``:
    maximum relative difference of v and w from odometry; the other factors are free.
    """
    reach = max_share * np.abs(odometry)
    low, high = odometry - reach, odometry + reach
    motion = np.concatenate([odometry, np.zeros(series.n_free)])
    for factor in FREE_NOISE_FACTORS:
        squares_px2 = series.squares(series.factors(motion)) @ products
        weight = weights(squares_px2, factor * NOISE_PX, counts)
        motion = series.step_within(motion, products @ weight, low, high)
    return motion
