"""The simulator's planar flow."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import numpy.typing as npt

import graphnav
from graphnav import Planar, Role, Stage, block_sum, param
from graphnav.arrays import Bools, Doubles

_MAX_PIXELS = 2000
MIN_PIXELS = 4
"""Number of pixels that determine a homography."""


class Truth(Stage):
    """Oracle: the flow of the ground at every pixel, also behind obstacles; isolates the planar model.

    Between two frames a plane moves by a homography. The true flow of the visible ground determines it, and it gives
    the flow of the rest. If too little ground is visible, and above its horizon, no cell is valid.
    """

    role: ClassVar[Role] = "oracle"

    cell_px: int = param(4, ge=1, le=4096, doc="side of the pixel blocks over which the flow is averaged")
    min_ground_ratio: float = param(
        0.01,
        gt=0.0,
        le=1.0,
        doc="minimum share of the picture that must be ground; less does not determine the motion of the plane",
        renamed_from="least_ground_ratio",
    )

    def step(self, truth: graphnav.Truth) -> Planar:
        """Return the ground's flow on cells of ``cell_px`` (of the truth's own step, if that is coarser)."""
        factor = max(1, self.cell_px // truth.step_px)
        uv_px, known = self._ground_flow(truth)
        size = block_sum(np.ones_like(known, np.float64), factor)
        mean = np.stack([block_sum(part, factor) / size for part in np.moveaxis(uv_px, -1, 0)], axis=-1)
        valid = block_sum(known.astype(np.float64), factor) == size
        return Planar(
            planar_uv_px=mean.astype(np.float32),
            planar_valid=valid.astype(np.uint8),
            residual_px=np.zeros(valid.shape, np.float32),
            interval_us=truth.interval_us,
            step_px=factor * truth.step_px,
        )

    def _ground_flow(self, truth: graphnav.Truth) -> tuple[Doubles, Bools]:
        """Return the ground's flow in px, (rows, cols, 2), and where it is known, (rows, cols); elsewhere it is 0."""
        rows, cols = truth.obstacle.shape
        unit_px = truth.step_px * cols / 2
        row, col = np.mgrid[:rows, :cols]
        points = np.stack([col - (cols - 1) / 2, row - (rows - 1) / 2], axis=-1) * (truth.step_px / unit_px)
        ground = np.flatnonzero((truth.obstacle == 0) & np.isfinite(truth.depth_m))
        none = np.zeros(points.shape), np.zeros((rows, cols), np.bool_)
        if ground.size < self.min_ground_ratio * truth.obstacle.size:
            return none
        used = ground[:: 1 + ground.size // _MAX_PIXELS]
        seen = points.reshape(-1, 2)[used]
        matrix = homography(seen, seen - truth.flow_px.reshape(-1, 2)[used] / unit_px)
        if matrix is None:
            return none
        before, scale = moved(matrix, points)
        known = (nearness(seen, truth.depth_m.reshape(-1)[used], points) > 0.0) & (scale > 0.0)
        return np.where(known[..., None], (points - before) * unit_px, 0.0), known


def homography(points: Doubles, before: Doubles) -> Doubles | None:
    """Return the homography (3, 3), float64, that takes ``points`` to ``before``, both (n, 2).

    Linear least squares with the last element 1 [HZ, section 4.1]: exact for exact points, and as accurate as the
    points if they are near the origin and of size about one. None if they do not determine it: fewer than four, or
    (nearly) on a line.

    References
    ----------
    .. [HZ] R. Hartley, A. Zisserman, Multiple View Geometry in Computer Vision, 2nd edition, 2004.
    """
    if len(points) < MIN_PIXELS:
        return None
    x, y = points.T
    one, none = np.ones_like(x), np.zeros_like(x)
    u, v = before.T
    rows_u = np.stack([x, y, one, none, none, none, -u * x, -u * y], axis=1)
    rows_v = np.stack([none, none, none, x, y, one, -v * x, -v * y], axis=1)
    found, _, rank, _ = np.linalg.lstsq(np.concatenate([rows_u, rows_v]), np.concatenate([u, v]), rcond=1e-9)
    if rank < found.size:
        return None
    return np.append(found, 1.0).reshape(3, 3)


def moved(matrix: Doubles, points: Doubles) -> tuple[Doubles, Doubles]:
    """Return the images of points (..., 2) under a homography, and their divisors (...).

    A divisor that is not positive means that the point of the plane lies behind the other camera.
    """
    places = points @ matrix[:, :2].T + matrix[:, 2]
    scale = places[..., 2]
    return places[..., :2] / np.where(scale == 0.0, np.inf, scale)[..., None], scale


def nearness(seen: Doubles, depth_m: npt.NDArray[np.floating], points: Doubles) -> Doubles:
    """Return one over the depth of the plane at ``points`` (..., 2), from its depth (n,) at the points ``seen`` (n, 2).

    It changes linearly over the picture; above the plane's horizon it is negative.
    """
    terms = np.column_stack([seen, np.ones(len(seen))])
    slope_x, slope_y, there = np.linalg.lstsq(terms, 1 / depth_m.astype(np.float64), rcond=None)[0]
    return np.asarray(points @ np.array([slope_x, slope_y]) + there)
