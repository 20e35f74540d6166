"""Whitening of two mixtures."""

from __future__ import annotations

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
    values, vectors = np.linalg.eigh(kept @ kept.T / mixtures.shape[1])
    if values[0] <= min_ratio * values[1]:
        return None
    matrix = (vectors / np.sqrt(values)).T
    return Whitened(matrix @ kept, matrix)
