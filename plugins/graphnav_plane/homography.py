"""Dominant plane as what one homography of the picture explains."""

from __future__ import annotations

from functools import lru_cache
from typing import Literal

import cv2
import numpy as np

from graphnav import Flow, FlowDeviation, Plane, Stamp, coarsen, param
from graphnav.arrays import Doubles
from graphnav_plane.agreement import agrees, length
from graphnav_plane.detector import MIN_VECTORS, Detector

Method = Literal["usac_magsac", "usac_default", "ransac", "lmeds"]

_METHODS = {
    "usac_magsac": cv2.USAC_MAGSAC,
    "usac_default": cv2.USAC_DEFAULT,
    "ransac": cv2.RANSAC,
    "lmeds": cv2.LMEDS,
}
_CONFIDENCE_RATIO = 0.99
_MAX_DRAWN_FROM = 256
"""From how many vectors the first homography is drawn, at most: every second, third... of more. The fits take all."""
_MIN_DEPTH_RATIO = 1e-6
_RIDGE = 1e-12

_UNIT_PX = 0.01
"""Unit of the coordinates passed to OpenCV. Its MAGSAC assumes noise of up to ten units: ten pixels are more than
obstacles move, so that it would fit plane and obstacles alike and leave no residual."""


class Homography(Detector):
    """Dominant plane by a robust homography between where the cells are and where they go.

    A plane seen by a moving camera moves as a homography exactly, at any tilt and for any displacement, where an
    affine map only nearly does. Needs no planar flow; takes the largest plane for the ground. The score is what the
    flow leaves of the homography's own flow.

    OpenCV draws a first homography from up to 256 vectors, taken evenly. It is then fitted by least squares to its
    inliers among all vectors, repeatedly, as `plane.affine` is. Where noise is as large as on real flow it then hardly
    matters what drew the first. OpenCV draws from generators that restart with every call: nothing here depends on a
    seed or on earlier runs.

    Where ``deviation`` is wired, a vector that is likely to be off by more than ``threshold_px`` counts for less in the
    fits, in proportion. Not in the score: flow is least certain at the edges of obstacles, which then are lost.

    References
    ----------
    .. [HZ] R. Hartley, A. Zisserman, Multiple View Geometry in Computer Vision, 2004, section 13.1.
    .. [MAGSAC++] D. Barath, J. Noskova, M. Ivashechkin, J. Matas, MAGSAC++, a Fast, Reliable and Accurate Robust
       Estimator, CVPR 2020.
    """

    cell_px: int = param(4, ge=1, le=4096, doc="side of the pixel blocks over which the flow is averaged")
    method: Method = param("usac_magsac", doc="what draws the first homography, by OpenCV's name")
    reprojection_px: float = param(
        0.1,
        gt=0.0,
        le=100_000.0,
        doc="what the first homography may leave of a vector that agrees with it; lmeds needs none",
    )
    draws: int = param(200, ge=1, le=100_000, doc="four-point draws, at most")
    refits: int = param(2, ge=0, le=100, doc="least-squares fits to the inliers of the previous fit")

    def step(self, flow: Flow, stamp: Stamp, deviation: FlowDeviation | None = None) -> Plane:
        """Return the plane on cells of ``cell_px``; nothing is judged where fewer than 6 vectors are valid."""
        self._begin(stamp)
        cells = coarsen(flow, max(self.cell_px, flow.step_px))
        valid = cells.valid != 0
        if np.count_nonzero(valid) < MIN_VECTORS:
            return self._unjudged(cells)
        everywhere, judged = cell_middles(*valid.shape, cells.step_px), np.flatnonzero(valid)
        vectors = cells.uv_px.reshape(-1, 2)
        places = everywhere.take(judged, axis=0)
        weights = np.ones(len(judged))
        if deviation is not None:
            sureness = deviation.sureness_at(valid.shape, cells.step_px, self.threshold_px)
            weights = sureness.take(judged).astype(np.float64)
        matrix = self._fitted(places, places + vectors.take(judged, axis=0), weights)
        left_px = (everywhere + vectors - moved(matrix, everywhere)).reshape(cells.uv_px.shape)
        return self._plane(self._remembered(left_px, valid, cells), valid, cells.step_px)

    def _fitted(self, places: Doubles, targets: Doubles, weights: Doubles) -> Doubles:
        """Return the homography (3, 3) that takes most of ``places`` (n, 2) to their ``targets``."""
        matrix = drawn(places, targets, self.method, self.reprojection_px, self.draws)
        for _ in range(self.refits):
            near = np.flatnonzero(agrees(weights * length(targets - moved(matrix, places)), self.threshold_px))
            matrix = least_squares(places.take(near, axis=0), targets.take(near, axis=0), weights.take(near))
        return matrix


def drawn(places: Doubles, targets: Doubles, method: Method, reprojection_px: float, draws: int) -> Doubles:
    """Return the homography (3, 3) that most vectors agree with, the one nearest to all if OpenCV finds none.

    ``places``, ``targets``: (n, 2), px. The other parameters are those of `Homography`.
    """
    every = -(-len(places) // _MAX_DRAWN_FROM)
    matrix, _ = cv2.findHomography(
        places[::every] / _UNIT_PX,
        targets[::every] / _UNIT_PX,
        _METHODS[method],
        reprojection_px / _UNIT_PX,
        maxIters=draws,
        confidence=_CONFIDENCE_RATIO,
    )
    if matrix is None or not np.isfinite(matrix).all():
        return least_squares(places, targets, np.ones(len(places)))
    return np.asarray(matrix * [[1.0, 1.0, _UNIT_PX], [1.0, 1.0, _UNIT_PX], [1 / _UNIT_PX, 1 / _UNIT_PX, 1.0]])


def least_squares(places: Doubles, targets: Doubles, weights: Doubles) -> Doubles:
    """Return the homography (3, 3) that takes ``places`` (n, 2) nearest to ``targets``, by the linear equations.

    ``weights``: (n,), of the differences.

    Solved for the difference from the identity, with a small ridge: finite even if all positions are collinear. The
    equations weigh a vector by its depth, which is nearly 1 where the motion between frames is small.
    """
    scale = max(1.0, float(np.abs(places).max()))
    x, y = np.ascontiguousarray(places.T) / scale
    to = np.ascontiguousarray(targets.T) / scale
    # An equation along x is (affine, 0, depth_x), one along y is (0, affine, depth_y).
    affine = weights * np.stack([x, y, np.ones_like(x)])
    depth_x, depth_y = -to[0] * affine[:2], -to[1] * affine[:2]
    added_x, added_y = weights * (to[0] - x), weights * (to[1] - y)
    products = _RIDGE * len(places) * np.eye(8)
    products[:3, :3] += affine @ affine.T
    products[3:6, 3:6] = products[:3, :3]
    products[:3, 6:] = affine @ depth_x.T
    products[3:6, 6:] = affine @ depth_y.T
    products[6:, :6] = products[:6, 6:].T
    products[6:, 6:] += depth_x @ depth_x.T + depth_y @ depth_y.T
    by = np.concatenate([affine @ added_x, affine @ added_y, depth_x @ added_x + depth_y @ added_y])
    added = np.linalg.solve(products, by)
    matrix = np.eye(3) + np.append(added, 0.0).reshape(3, 3)
    return np.asarray(matrix * [[1.0, 1.0, scale], [1.0, 1.0, scale], [1 / scale, 1 / scale, 1.0]])


@lru_cache(maxsize=16)
def cell_middles(rows: int, cols: int, step_px: int) -> Doubles:
    """Return the middles of all cells, px right and down of the picture's middle, (rows * cols, 2)."""
    y, x = np.mgrid[:rows, :cols].reshape(2, -1)
    places = step_px * np.column_stack([x - (cols - 1) / 2, y - (rows - 1) / 2])
    places.setflags(write=False)
    return places


def moved(matrix: Doubles, places: Doubles) -> Doubles:
    """Return the images of ``places`` under ``matrix``, (n, 2).

    Points at the horizon or beyond are clamped just before it: huge but finite.
    """
    images = places @ matrix[:, :2].T + matrix[:, 2]
    return np.asarray(images[:, :2] / np.maximum(images[:, 2:], _MIN_DEPTH_RATIO))
