"""Whitening of two mixtures."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from graphnav.arrays import Doubles


class Whitened(NamedTuple):
    """Two uncorrelated rows of unit mean square.

    ``samples``: (2, n). ``matrix``: (2, 2), makes them of the (centred) mixtures.
    """

    samples: Doubles
    matrix: Doubles


def whiten(mixtures: Doubles, min_ratio: float, *, centred: bool = True) -> Whitened | None:
    """Return ``mixtures`` (2, n) whitened, None if they are linearly dependent.

    They are if the smaller eigenvalue of their covariance is at most ``min_ratio`` times the larger. Unless
    ``centred``, the second moment about zero replaces the covariance.
    """
    kept = mixtures - mixtures.mean(axis=1, keepdims=True) if centred else mixtures
    (xx, xy), (_, yy) = (kept @ kept.T / mixtures.shape[1]).tolist()
    middle, radius = (xx + yy) / 2, math.hypot((xx - yy) / 2, xy)
    small, large = middle - radius, middle + radius
    if small <= min_ratio * large:
        return None
    angle = math.atan2(2 * xy, xx - yy) / 2
    c, s = math.cos(angle), math.sin(angle)
    small_root, large_root = math.sqrt(small), math.sqrt(large)
    matrix = np.array([[-s / small_root, c / small_root], [c / large_root, s / large_root]])
    return Whitened(matrix @ kept, matrix)
