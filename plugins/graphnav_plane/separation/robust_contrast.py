"""FastICA of two mixtures with the Gaussian nonlinearity, by a search over the single angle.

The contrast is E[exp(-y^2 / 2)] of the component y, maximal if many samples are near zero: FastICA's choice for
sparse sources [Hyvärinen: Fast and Robust Fixed-Point Algorithms for Independent Component Analysis, 1999]. Unlike the
kurtosis it does not grow with the few largest samples, so that a large obstacle does not decide what counts as ground.

FastICA's own iteration, w = E[x g(w'x)] - E[g'(w'x)] w with g(y) = y exp(-y^2 / 2), ends in some extremum. Here it
starts from the best of several angles on a subset of the samples, and so ends in the maximum.
"""

from __future__ import annotations

import numpy as np

from graphnav.arrays import Doubles

_ANGLES = 32
_TRIED = 600
_ITERATIONS = 20
_TOLERANCE = 1e-6


def rotation(samples: Doubles) -> Doubles:
    """Return the rotation (2, 2) whose rows take whitened samples (2, n) to the components, the sparsest first."""
    c, s = _best_of_some(samples[:, :: max(1, samples.shape[1] // _TRIED)])
    a, b = samples
    for _ in range(_ITERATIONS):
        y = c * a + s * b
        squares = y * y
        bell = np.exp(-squares / 2)
        slope = float(((1 - squares) * bell).mean())
        bell *= y
        c_next, s_next = float(a @ bell) / y.size - slope * c, float(b @ bell) / y.size - slope * s
        length = np.hypot(c_next, s_next)
        if not length:
            break
        change = (c * s_next - s * c_next) / length
        c, s = c_next / length, s_next / length
        if abs(change) < _TOLERANCE:
            break
    return np.array([[c, s], [-s, c]])


def _best_of_some(samples: Doubles) -> tuple[float, float]:
    """Return cosine and sine of the angle of maximum contrast, of 32 around half a circle."""
    angles = np.arange(_ANGLES) * (np.pi / _ANGLES)
    y = np.column_stack([np.cos(angles), np.sin(angles)]).astype(np.float32) @ samples.astype(np.float32)
    y *= y
    y *= np.float32(-0.5)
    best = angles[np.argmax(np.exp(y, out=y).sum(axis=1))]
    return float(np.cos(best)), float(np.sin(best))
