"""Estimate the motion of a frame from its flow alone, robust against obstacles."""

from __future__ import annotations

import numpy as np

from graphnav.arrays import Doubles
from graphnav_planar.estimation.robust import agreement
from graphnav_planar.estimation.series import Series

_PAIR = 2
_STEPS_OF_PAIRS = 3
_ITERATIONS = 4
_MAX_JUDGES = 400
"""Number of vectors that select the start; as many distinguish good from bad as well as all do."""


def motions_of_pairs(series: Series, uv_px: Doubles, count: int, rng: np.random.Generator) -> Doubles:
    """Return the motions that explain ``count`` random pairs of vectors, (count, 2).

    ``uv_px``: (2n,), the flow, laid out as the fields of ``series``. Two vectors give four equations for two unknowns.
    """
    n = uv_px.size // 2
    cells = rng.integers(n, size=(count, _PAIR))
    both = np.concatenate([cells, cells + n], axis=1)
    fields = series.basis[:, both].transpose(1, 0, 2)
    products = fields @ fields.swapaxes(-1, -2)
    moments = (fields @ uv_px[both][..., None])[..., 0]
    motions = np.zeros((count, 2))
    for _ in range(_STEPS_OF_PAIRS):
        motions = series.step(motions, products, moments)
    return motions


def best_motion(series: Series, uv_px: Doubles, motions: Doubles, noise_px: float) -> Doubles:
    """Return the motion among ``motions`` (m, 2) with which most of the flow agrees, (2,)."""
    n = uv_px.size // 2
    some = np.arange(0, n, 1 + n // _MAX_JUDGES)
    both = np.concatenate([some, some + n])
    left_px = uv_px[both] - series.factors(motions) @ series.basis[:, both]
    explained = agreement(left_px, noise_px).sum(axis=-1)
    return np.asarray(motions[np.argmax(explained)])


def fitted_motion(series: Series, uv_px: Doubles, start: Doubles, noise_px: float) -> Doubles:
    """Refine the motion with which most of the flow agrees, (2,), from a start near it.

    Least squares, reweighted at each step: a vector that differs by much more than ``noise_px`` has no weight.
    """
    motion = start
    for _ in range(_ITERATIONS):
        explained = agreement(uv_px - series.factors(motion) @ series.basis, noise_px)
        weighted = series.basis * np.tile(explained * explained, 2)
        motion = series.step(motion, weighted @ series.basis.T, weighted @ uv_px)
    return motion
