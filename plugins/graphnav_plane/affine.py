"""Dominant plane by an affine motion of the picture."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np

from graphnav import Flow, Plane, Stamp, coarsen, param
from graphnav.arrays import Bools, Doubles
from graphnav_plane.agreement import inlier_limit_px, length, median
from graphnav_plane.detector import MIN_VECTORS, Detector

_SAMPLE = 200
_MIN_AREA = 1e-3
_RIDGE = 1e-9


class Affine(Detector):
    """Dominant plane by a robust affine fit of the flow.

    A plane seen by a moving camera flows as ``u = (A - I) x + b`` if the displacement and the tilt of the plane are
    small. Fits (A, b) by least median of squares over seeded three-point draws, then by least squares to all inliers;
    the score is the residual. Needs no planar flow; assumes that the largest plane is the ground.

    References
    ----------
    .. [OI] N. Ohnishi, A. Imiya, Combination of Supervised and Unsupervised Methods for Navigation Path Mining,
       section 2.
    .. [LMedS] P. J. Rousseeuw, Least Median of Squares Regression, 1984.
    """

    mad_ratio: float = param(
        3.5,
        gt=0.0,
        le=1e6,
        doc="rule mad: more marks fewer cells as obstacle; lower than that of plane.ica, because perspective raises "
        "the median of the residual of an affine fit",
    )
    cell_px: int = param(4, ge=1, le=4096, doc="side of the pixel blocks over which the flow is averaged")
    draws: int = param(
        100, ge=1, le=10_000, doc="three-point draws: 35 miss the plane once in 100 frames at half obstacle"
    )
    refits: int = param(2, ge=1, le=100, doc="least-squares fits to the inliers of the previous fit")

    def reset(self, seed: int) -> None:
        """Restart the draws and forget the last frames."""
        super().reset(seed)
        self._rng = np.random.default_rng(seed)

    def step(self, flow: Flow, stamp: Stamp) -> Plane:
        """Return the plane on cells of ``cell_px``; nothing is judged where fewer than 6 vectors are valid."""
        self._begin(stamp)
        cells = coarsen(flow, max(self.cell_px, flow.step_px))
        valid = cells.valid != 0
        if np.count_nonzero(valid) < MIN_VECTORS:
            return self._unjudged(cells)
        everywhere, judged = _places(*valid.shape), np.flatnonzero(valid)
        uv = cv2.copyTo(cells.uv_px, cells.valid).reshape(-1, 2).astype(np.float64)
        fit = self._drawn(everywhere.take(judged, axis=0), uv.take(judged, axis=0))
        if fit is None:
            fit = least_squares(uv, valid)
        for _ in range(self.refits):
            left_px = length(uv - everywhere @ fit)
            near = left_px <= inlier_limit_px(left_px.take(judged), self.threshold_px)
            fit = least_squares(uv, near.reshape(valid.shape) & valid)
        left_uv_px = cells.uv_px - (everywhere @ fit).reshape(cells.uv_px.shape)
        return self._plane(self._remembered(left_uv_px, valid, cells), valid, cells.step_px)

    def _drawn(self, places: Doubles, uv: Doubles) -> Doubles | None:
        """Return the fit (3, 2) to the three vectors with the minimum median residual, over a sample of all vectors.

        Without three vectors that are not on a line there is none.
        """
        n = len(places)
        drawn = self._rng.integers(0, n, (3, self.draws))
        (x0, x1, x2), (y0, y1, y2) = places[drawn, 0], places[drawn, 1]
        area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
        proper = np.abs(area) > _MIN_AREA
        if not proper.any():
            return None
        area = np.where(proper, area, np.inf)
        u0, u1, u2 = uv[drawn].transpose(0, 2, 1)
        along_x = ((u1 - u0) * (y2 - y0) - (u2 - u0) * (y1 - y0)) / area
        along_y = ((u2 - u0) * (x1 - x0) - (u1 - u0) * (x2 - x0)) / area
        fits = np.stack([along_x, along_y, u0 - along_x * x0 - along_y * y0]).astype(np.float32)
        every = max(1, n // _SAMPLE)
        sample, seen = places[::every].T.astype(np.float32), uv[::every].T.astype(np.float32)
        left_u, left_v = fits[:, 0].T @ sample - seen[0], fits[:, 1].T @ sample - seen[1]
        squares = left_u * left_u
        squares += left_v * left_v
        medians = np.where(proper, median(squares), np.inf)
        return fits[:, :, np.argmin(medians)].astype(np.float64)


@lru_cache(maxsize=16)
def _places(rows: int, cols: int) -> Doubles:
    """Return (x, y, 1) of all cells, x and y from -1 to 1 across the picture, (rows * cols, 3)."""
    y, x = np.mgrid[:rows, :cols].reshape(2, -1)
    places = np.column_stack([(2 * x - cols + 1) / cols, (2 * y - rows + 1) / rows, np.ones(rows * cols)])
    places.setflags(write=False)
    return places


@lru_cache(maxsize=16)
def _products(rows: int, cols: int) -> Doubles:
    """Return the products of any two of (x, y, 1), of all cells, (rows * cols, 9)."""
    places = _places(rows, cols)
    products: Doubles = (places[:, :, None] * places[:, None]).reshape(-1, 9)
    products.setflags(write=False)
    return products


def least_squares(uv: Doubles, near: Bools) -> Doubles:
    """Return the affine fit (3, 2), the factors of x, y and 1, to the vectors where ``near``, (rows, cols).

    ``uv``: (rows * cols, 2) px. A small ridge keeps it finite if all positions are collinear.
    """
    rows, cols = near.shape
    products = (near.ravel().astype(np.float64) @ _products(rows, cols)).reshape(3, 3)
    count = products[2, 2]
    products += _RIDGE * count * np.eye(3)
    near_uv = cv2.copyTo(uv.reshape(rows, cols, 2), near.view(np.uint8)).reshape(-1, 2)
    return np.asarray(np.linalg.solve(products, _places(rows, cols).T @ near_uv))
