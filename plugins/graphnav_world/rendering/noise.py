"""Fast image noise."""

from __future__ import annotations

from statistics import NormalDist

import numpy as np

from graphnav.arrays import Floats

STEPS = 4096
_QUANTILES: Floats = np.array([NormalDist().inv_cdf((k + 0.5) / STEPS) for k in range(STEPS)], np.float32)


def normal_noise(shape: tuple[int, ...], sigma: float, rng: np.random.Generator) -> Floats:
    """Return Gaussian noise, float32, cut to 4096 quantiles (within 3.7 sigma): a fifth of the cost of exact draws."""
    draws = rng.integers(0, STEPS, size=shape, dtype=np.uint16).astype(np.intp)
    return (_QUANTILES * np.float32(sigma)).take(draws)
