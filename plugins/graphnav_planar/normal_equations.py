"""Streaming least squares: a small linear fit per cell of a grid, stored as normal equations."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from graphnav.arrays import Bools, Doubles, Floats

_WORST_CONDITION = 1e8


class Solution(NamedTuple):
    """``fields``: (k, rows, cols, 2). ``residual``: (rows, cols), the root mean square length of the residual."""

    fields: Doubles
    residual: Doubles


class NormalEquations:
    """Fits ``y = sum_k factor_k * field_k`` for every cell of a grid, from one (factors, y) per frame.

    All state is a sum over the frames, so memory does not depend on their number.

    Parameters
    ----------
    terms
        Number of factors, k.
    rows, cols
        Size of the grid.
    """

    def __init__(self, terms: int, rows: int, cols: int) -> None:
        self._products = np.zeros((rows, cols, terms, terms))
        self._moments = np.zeros((rows, cols, terms, 2))
        self._squares = np.zeros((rows, cols))
        self.count = np.zeros((rows, cols), np.int64)

    def add(self, factors: Doubles, uv_px: Floats, valid: Bools) -> None:
        """Add a frame: factors (k,), vectors (rows, cols, 2), and the cells whose vector counts."""
        uv = uv_px[valid].astype(np.float64)
        self._products[valid] += np.outer(factors, factors)
        self._moments[valid] += factors[:, None] * uv[:, None, :]
        self._squares[valid] += (uv * uv).sum(axis=1)
        self.count[valid] += 1

    def solve(self, cells: Bools) -> Solution | None:
        """Return the fit, 0 outside ``cells``; None if the frames do not determine it for each of these cells."""
        rows, cols, terms, _ = self._moments.shape
        fields, left = np.zeros((terms, rows, cols, 2)), np.zeros((rows, cols))
        products = self._products[cells]
        scale = np.sqrt(np.einsum("nkk->nk", products))
        if not len(scale) or not scale.all():
            return None
        scaled = products / (scale[:, :, None] * scale[:, None, :])
        if np.linalg.cond(scaled).max() > _WORST_CONDITION:
            return None
        moments = self._moments[cells]
        solution = np.linalg.solve(scaled, moments / scale[:, :, None]) / scale[:, :, None]
        fields[:, cells] = solution.transpose(1, 0, 2)
        explained = (solution * moments).sum(axis=(1, 2))
        left[cells] = np.sqrt(np.maximum(self._squares[cells] - explained, 0.0) / self.count[cells])
        return Solution(fields, left)
