"""Fast image noise."""

from __future__ import annotations

import math
from statistics import NormalDist

import numpy as np

from graphnav.arrays import Floats

BITS = 12
STEPS = 2**BITS
_QUANTILES: Floats = np.array([NormalDist().inv_cdf((k + 0.5) / STEPS) for k in range(STEPS)], np.float32)


def normal_noise(shape: tuple[int, ...], rng: np.random.Generator) -> Floats:
    """Return Gaussian noise of sigma 1, float32, cut to 4096 quantiles: a tenth of the cost of exact draws.

    Each value takes the high bits of 16 random ones.
    """
    size = math.prod(shape)
    if size % 4 == 0:
        words = rng.bit_generator.random_raw(size // 4)
    else:  # the same bits, from words of which none is drawn in part
        words = rng.integers(0xFFFFFFFF, size=(size + 1) // 2, dtype=np.uint32, endpoint=True)
    draws = words.view(np.uint16)[:size] >> (16 - BITS)
    return _QUANTILES.take(draws.astype(np.intp)).reshape(shape)
