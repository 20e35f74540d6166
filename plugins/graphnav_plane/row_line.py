"""Dominant plane by a straight line through the flow of each image row: a baseline without a model."""

from __future__ import annotations

from itertools import combinations
from typing import ClassVar

import numpy as np

from graphnav import Flow, Plane, Role, Stamp, coarsen, param
from graphnav.arrays import Bools, Doubles, Indices
from graphnav_plane.detector import MIN_VECTORS, Detector

_COLUMNS = 8
_SIGMA_OF_MEDIAN = 1.4826
_INLIER_SIGMAS = 2.5
_RIDGE = 1e-6


class RowLine(Detector):
    """Baseline: obstacle is what leaves the straight line through the flow of its image row.

    In each row a line ``u(x) = a + b x`` (two numbers for u, two for v) is fitted by least median of squares over pairs
    of cells, then by least squares to its inliers. The rows share nothing, so that no plane, camera or motion is
    modelled; a level floor's flow is nearly straight along a row even in turns. A row whose larger half is obstacle
    has the wrong line. In a row with fewer than 4 valid vectors nothing differs from it.
    """

    role: ClassVar[Role] = "baseline"

    cell_px: int = param(4, ge=1, le=4096, doc="side of the pixel blocks over which the flow is averaged")
    refits: int = param(2, ge=0, le=100, doc="least-squares fits to the inliers of the previous fit")

    def step(self, flow: Flow, stamp: Stamp) -> Plane:
        """Return the plane on cells of ``cell_px``; nothing is judged where fewer than 6 vectors are valid."""
        self._begin(stamp)
        cells = coarsen(flow, max(self.cell_px, flow.step_px))
        valid = cells.valid != 0
        if np.count_nonzero(valid) < MIN_VECTORS:
            return self._unjudged(cells)
        uv_px = np.where(valid[..., None], cells.uv_px, np.float32(0)).astype(np.float64)
        left_px = row_residuals(uv_px, valid, self.refits, self.threshold_px)
        return self._plane(self._remembered(left_px, valid, cells), valid, cells.step_px)


def row_residuals(uv_px: Doubles, valid: Bools, refits: int, noise_px: float) -> Doubles:
    """Return what the robust line of each row leaves of ``uv_px``, (rows, cols, 2); 0 with fewer than 4 vectors.

    ``noise_px``: what is left by this or less always agrees with a line.
    """
    x = np.linspace(-1.0, 1.0, valid.shape[1])
    left_px = _best_of_pairs(uv_px, valid, x)
    for _ in range(refits):
        squares = np.einsum("rci,rci->rc", left_px, left_px)
        sigma = np.maximum(_SIGMA_OF_MEDIAN * np.sqrt(_medians(squares, valid)), noise_px / _INLIER_SIGMAS)
        near = valid & (squares <= (_INLIER_SIGMAS * sigma[:, None]) ** 2)
        left_px = _least_squares(uv_px, near, x)
    return np.asarray(left_px * ((valid.sum(axis=1) >= 4)[:, None] & valid)[..., None])


def _best_of_pairs(uv_px: Doubles, valid: Bools, x: Doubles) -> Doubles:
    """Return what is left by the line of the pair of cells with the minimum median residual, (rows, cols, 2)."""
    rows = np.arange(len(valid))
    best_px, best = _least_squares(uv_px, valid, x), np.full(len(valid), np.inf)
    for first, second in combinations(_spread(valid).T, 2):
        slope = (uv_px[rows, second] - uv_px[rows, first]) / np.where(second > first, x[second] - x[first], 1.0)[
            :, None
        ]
        left_px = uv_px - uv_px[rows, first][:, None] - slope[:, None] * (x - x[first][:, None])[..., None]
        medians = _medians(np.einsum("rci,rci->rc", left_px, left_px), valid)
        better = (medians < best) & (second > first)
        best = np.where(better, medians, best)
        best_px = np.where(better[:, None, None], left_px, best_px)
    return best_px


def _spread(valid: Bools) -> Indices:
    """Return 8 valid columns of each row, spread evenly, ascending, (rows, 8); repeated where there are less."""
    order = np.argsort(~valid, axis=1, kind="stable")
    count = np.maximum(valid.sum(axis=1), 1)
    ranks = (np.linspace(0.0, 1.0, _COLUMNS) * (count[:, None] - 1)).astype(np.intp)
    return np.take_along_axis(order, ranks, axis=1)


def _medians(squares: Doubles, valid: Bools) -> Doubles:
    """Return the upper median of the valid squares of each row, (rows,); infinite without any."""
    ordered = np.sort(np.where(valid, squares, np.inf), axis=1)
    middle = np.minimum(valid.sum(axis=1) // 2, valid.shape[1] - 1)
    return np.asarray(ordered[np.arange(len(valid)), middle])


def _least_squares(uv_px: Doubles, near: Bools, x: Doubles) -> Doubles:
    """Return what the line through the vectors ``near`` leaves of all vectors, (rows, cols, 2)."""
    weight = near.astype(np.float64)
    count = np.maximum(weight.sum(axis=1), 1.0)
    middle = weight @ x / count
    away = x - middle[:, None]
    mean_px = np.einsum("rc,rci->ri", weight, uv_px) / count[:, None]
    spread = np.einsum("rc,rc->r", weight, away**2) + _RIDGE
    slope = np.einsum("rc,rci->ri", weight * away, uv_px) / spread[:, None]
    return np.asarray(uv_px - mean_px[:, None] - slope[:, None] * away[..., None])
