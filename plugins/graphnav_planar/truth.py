"""The simulator's planar flow."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

import graphnav
from graphnav import Planar, Role, Stage, block_sum, param
from graphnav.arrays import Bools, Doubles
from graphnav_planar.homography import homography, moved, nearness

_MAX_PIXELS = 2000


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
