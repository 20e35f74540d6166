"""FastICA of two mixtures with the Gaussian nonlinearity, by a search over the single angle.

The contrast is E[exp(-y^2 / 2)] of the component y, maximal if many samples are near zero: FastICA's choice for
sparse sources [Hyvärinen: Fast and Robust Fixed-Point Algorithms for Independent Component Analysis, 1999]. Unlike the
kurtosis it does not grow with the few largest samples, so that a large obstacle does not decide what counts as ground.

FastICA's own iteration, w = E[x g(w'x)] - E[g'(w'x)] w with g(y) = y exp(-y^2 / 2), ends in some extremum. Here it
starts from the best of several angles on a subset of the samples, and so ends in the maximum.

For two whitened rows (a, b) and w = (c, s), y^2 = c^2 a^2 + 2 c s a b + s^2 b^2. So the exponents are one product of
the samples' products (a^2, a b, b^2), which do not change, with a vector; and so are the expectations.
"""

from __future__ import annotations

import math
from functools import cache

import cv2
import numpy as np

from graphnav.arrays import Doubles, Floats

_ANGLES = 32
_TRIED = 600
_ITERATIONS = 20
_TOLERANCE = 1e-6


def rotation(samples: Doubles) -> Doubles:
    """Return the rotation (2, 2) whose rows take whitened samples (2, n) to the components, the sparsest first.

    In float32, which leaves the angle uncertain by less than the tolerance of the iteration.
    """
    products = _products(samples)
    c, s = _best_of_some(products[:3, :: max(1, samples.shape[1] // _TRIED)])
    for _ in range(_ITERATIONS):
        bell = _bell(np.array([-0.5 * c * c, -c * s, -0.5 * s * s], np.float32) @ products[:3])
        aa, ab, bb, one = (products @ bell).tolist()
        slope = one - (c * c * aa + 2 * c * s * ab + s * s * bb)
        c_next, s_next = c * aa + s * ab - slope * c, c * ab + s * bb - slope * s
        length = math.hypot(c_next, s_next)
        if not length:
            break
        change = (c * s_next - s * c_next) / length
        c, s = c_next / length, s_next / length
        if abs(change) < _TOLERANCE:
            break
    return np.array([[c, s], [-s, c]])


def _products(samples: Doubles) -> Floats:
    """Return a^2, a b, b^2 and 1 of samples (a, b), (4, n)."""
    a, b = samples.astype(np.float32)
    products = np.ones((4, a.size), np.float32)
    np.multiply(a, a, out=products[0])
    np.multiply(a, b, out=products[1])
    np.multiply(b, b, out=products[2])
    return products


def _best_of_some(products: Floats) -> tuple[float, float]:
    """Return cosine and sine of the angle of maximum contrast, of 32 around half a circle."""
    best = int(np.argmax(_bell(_exponents() @ products).sum(axis=1))) * math.pi / _ANGLES
    return math.cos(best), math.sin(best)


@cache
def _exponents() -> Floats:
    """Return the factors of a^2, a b and b^2 in -y^2 / 2 at each angle, (angles, 3)."""
    angles = np.arange(_ANGLES) * (np.pi / _ANGLES)
    c, s = np.cos(angles), np.sin(angles)
    return np.column_stack([-0.5 * c * c, -c * s, -0.5 * s * s]).astype(np.float32)


def _bell(exponents: Floats) -> Floats:
    """Return their exponentials, in place: four times as fast as numpy's."""
    cv2.exp(exponents, exponents)
    return exponents
