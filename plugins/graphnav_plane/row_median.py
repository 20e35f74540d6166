"""Dominant plane by the length of the flow in each image row: a baseline without a model."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from graphnav import Flow, Plane, Role, Stamp, coarsen, param
from graphnav.arrays import Bools, Floats
from graphnav_plane.detector import MIN_VECTORS, Detector

_MIN_PX = 1e-6


class RowMedian(Detector):
    """Baseline: obstacle is where the flow is longer or shorter than the median of its image row.

    Knows neither the camera, nor the motion, nor a plane: only that the floor of one row is at one distance if the
    camera is level, so that its flow is equally long while the robot drives straight on. Where it arrives, the world
    does not need a model of the ground.
    """

    role: ClassVar[Role] = "baseline"

    cell_px: int = param(4, ge=1, le=4096, doc="side of the pixel blocks over which the flow is averaged")

    def step(self, flow: Flow, stamp: Stamp) -> Plane:
        """Return the plane on cells of ``cell_px``; nothing is judged where fewer than 6 vectors are valid."""
        self._begin(stamp)
        cells = coarsen(flow, max(self.cell_px, flow.step_px))
        valid = cells.valid != 0
        if np.count_nonzero(valid) < MIN_VECTORS:
            return self._unjudged(cells)
        length_px = np.where(valid, np.hypot(cells.uv_px[..., 0], cells.uv_px[..., 1]), np.float32(0))
        excess = 1 - row_medians(length_px, valid)[:, None] / np.maximum(length_px, np.float32(_MIN_PX))
        left_px = cells.uv_px * excess[..., None]
        return self._plane(self._remembered(left_px, valid, cells), valid, cells.step_px)


def row_medians(values: Floats, valid: Bools) -> Floats:
    """Return the lower median of the ``valid`` values of each row, (rows,); 0 for a row without any."""
    ordered = np.sort(np.where(valid, values, np.float32(np.inf)), axis=1)
    count = np.count_nonzero(valid, axis=1)
    middle = ordered[np.arange(len(values)), np.maximum(count - 1, 0) // 2]
    return np.asarray(np.where(count > 0, middle, np.float32(0)))
