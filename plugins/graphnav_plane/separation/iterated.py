"""FastICA as published, by scikit-learn: the reference for the direct solutions."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from graphnav.arrays import Doubles

Nonlinearity = Literal["gauss", "cubic"]

_FUNCTIONS = {"gauss": "exp", "cubic": "cube"}

ITERATIONS = 1000
TOLERANCE = 1e-4


class Rotated(NamedTuple):
    """``rotation``: (2, 2), its rows take whitened samples to the components in the order found."""

    rotation: Doubles
    converged: bool


def rotation(samples: Doubles, start: Doubles, nonlinearity: Nonlinearity) -> Rotated:
    """Return the rotation that FastICA finds for whitened samples (2, n), by deflation.

    ``start``: (2, 2), the initial rows. Tolerance and iterations are those of the package used in [OI].
    """
    from sklearn.decomposition import fastica

    _, found, _, iterations = fastica(
        samples.T,
        algorithm="deflation",
        fun=_FUNCTIONS[nonlinearity],
        whiten=False,
        max_iter=ITERATIONS,
        tol=TOLERANCE,
        w_init=start,
        return_n_iter=True,
    )
    return Rotated(np.asarray(found, np.float64), bool(iterations < ITERATIONS))
