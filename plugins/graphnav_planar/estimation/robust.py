"""Geman and McClure's estimator: weights of vectors in a fit that is robust against obstacles."""

from __future__ import annotations

from graphnav.arrays import Doubles

NOISE_PX = 0.1
NOISE_DOC = (
    "flow noise: a vector that differs by this from the ground has a weight of a quarter, one of ten times as much none"
)


def agreement(left_px: Doubles, noise_px: float) -> Doubles:
    """Return the agreement of each vector with a fit, from 1 down to 0, (..., n).

    ``left_px``: (..., 2n), the residuals of n vectors: horizontal parts, then vertical ones. A residual of ``noise_px``
    gets 1/2. The square is the weight in the next least-squares step; the sum is the maximized objective.
    """
    n = left_px.shape[-1] // 2
    squares = left_px * left_px
    explained: Doubles = 1 / (1 + (squares[..., :n] + squares[..., n:]) / noise_px**2)
    return explained
