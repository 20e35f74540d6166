"""Estimate the motion of a frame from its flow alone, robust against obstacles."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from graphnav.arrays import Doubles
from graphnav_planar.estimation.robust import agreement, weights
from graphnav_planar.estimation.series import Series

Indices = npt.NDArray[np.intp]

_PAIR = 2
_STEPS_OF_PAIRS = 3
_ITERATIONS = 4
_MAX_JUDGES = 400
"""Number of vectors that select the start; as many distinguish good from bad as well as all do."""


def motions_of_pairs(series: Series, products: Doubles, seen: Indices, count: int, rng: np.random.Generator) -> Doubles:
    """Return the motions that explain ``count`` random pairs of vectors, (2, count).

    ``products``: (products, n), of ``series``; ``seen``: which of the n vectors count. Two vectors give four equations
    for two unknowns.
    """
    pairs = seen[rng.integers(len(seen), size=(count, _PAIR))]
    sums = products.take(pairs, axis=1).sum(axis=-1).T
    motions = np.zeros((2, count))
    for _ in range(_STEPS_OF_PAIRS):
        motions = series.step(motions, series.factors(motions), sums)
    return motions


def best_motion(series: Series, products: Doubles, seen: Indices, motions: Doubles, noise_px: float) -> Doubles:
    """Return the motion among ``motions`` (2, m) with which most of the flow agrees, (2,)."""
    judges = products.take(seen[:: 1 + len(seen) // _MAX_JUDGES], axis=1)
    squares_px2 = series.squares(series.factors(motions)) @ judges
    return np.asarray(motions[:, agreement(squares_px2, noise_px).sum(axis=-1).argmax()])


def fitted_motion(series: Series, products: Doubles, counts: Doubles, start: Doubles, noise_px: float) -> Doubles:
    """Refine the motion with which most of the flow agrees, (2,), from a start near it.

    ``counts``: (n,), 1 for a vector that counts, 0 for others. Least squares, reweighted at each step: a vector that
    differs by much more than ``noise_px`` has no weight.
    """
    motion = start
    for _ in range(_ITERATIONS):
        factors = series.factors(motion)
        weight = weights(series.squares(factors) @ products, noise_px, counts)
        motion = series.step(motion, factors, products @ weight)
    return motion
