"""Geman and McClure's estimator: what each vector weighs in a fit that obstacles must not draw."""

from __future__ import annotations

from graphnav.arrays import Doubles

NOISE_PX = 0.1
NOISE_DOC = (
    "flow noise: a vector that differs by this much from the ground counts a quarter, one of ten times as much nothing"
)


def agreement(left_px: Doubles, noise_px: float) -> Doubles:
    """Return how well a fit explains each vector, from 1 down to 0, (..., n).

    ``left_px``: (..., 2n), what it leaves of n vectors: their horizontal parts, then the vertical ones. One that
    differs by ``noise_px`` gets 1/2. The square is its weight in the next least squares, the sum is what is maximized.
    """
    n = left_px.shape[-1] // 2
    squares = left_px * left_px
    explained: Doubles = 1 / (1 + (squares[..., :n] + squares[..., n:]) / noise_px**2)
    return explained
