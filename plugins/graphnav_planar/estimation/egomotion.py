"""Estimate the motion of a frame from its flow alone, robust against obstacles."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from graphnav.arrays import Doubles
from graphnav_planar.estimation.robust import agreement, weights
from graphnav_planar.estimation.series import Series

Indices = npt.NDArray[np.intp]

_STEPS_OF_SUBSETS = 3
_NOISE_FACTORS = (1.0, 1.0, 1.0, 1.0)
FREE_NOISE_FACTORS = (16.0, 8.0, 4.0, 2.0, 1.0, 1.0, 1.0, 1.0)
"""Graduated non-convexity: free factors make the objective rough, and a start near its maximum rare. A first fit in
which larger differences count has one maximum; the next ones narrow it down."""
_MAX_JUDGES = 400
"""Number of vectors that select the start; as many distinguish good from bad as well as all do."""


def motions_of_subsets(
    series: Series, products: Doubles, seen: Indices, count: int, rng: np.random.Generator
) -> Doubles:
    """Return the motions that explain ``count`` random subsets of vectors, (unknowns, count).

    ``products``: (products, n), of ``series``; ``seen``: which of the n vectors count. A subset has as many vectors as
    there are unknowns, each of two equations.
    """
    subsets = seen[rng.integers(len(seen), size=(count, series.unknowns))]
    sums = products.take(subsets, axis=1).sum(axis=-1).T
    motions = np.zeros((series.unknowns, count))
    for _ in range(_STEPS_OF_SUBSETS):
        motions = series.step(motions, series.factors(motions), sums)
    return motions


def best_motion(series: Series, products: Doubles, seen: Indices, motions: Doubles, noise_px: float) -> Doubles:
    """Return the motion among ``motions`` (unknowns, m) with which most of the flow agrees, (unknowns,)."""
    judges = products.take(seen[:: 1 + len(seen) // _MAX_JUDGES], axis=1)
    squares_px2 = series.squares(series.factors(motions)) @ judges
    return np.asarray(motions[:, agreement(squares_px2, noise_px).sum(axis=-1).argmax()])


def fitted_motion(series: Series, products: Doubles, counts: Doubles, start: Doubles, noise_px: float) -> Doubles:
    """Refine the motion with which most of the flow agrees, (unknowns,), from a start near it.

    ``counts``: (n,), 1 for a vector that counts, 0 for others. Least squares, reweighted at each step: a vector that
    differs by much more than ``noise_px`` has no weight.
    """
    motion = start
    for factor in FREE_NOISE_FACTORS if series.n_free else _NOISE_FACTORS:
        factors = series.factors(motion)
        weight = weights(series.squares(factors) @ products, factor * noise_px, counts)
        motion = series.step(motion, factors, products @ weight)
    return motion
