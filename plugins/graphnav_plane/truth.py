"""The simulator's dominant plane."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

import graphnav
from graphnav import Plane, Role, Stage, block_sum, param


class Truth(Stage):
    """Oracle: the true obstacles of the simulator. The score is the share of a cell that is obstacle.

    Cells entirely above the horizon are not valid.
    """

    role: ClassVar[Role] = "oracle"

    cell_px: int = param(4, ge=1, le=4096, doc="side of the pixel blocks that become one cell")
    threshold_ratio: float = param(0.5, ge=0.0, lt=1.0, doc="a cell is obstacle if more than this share of it is")

    def step(self, truth: graphnav.Truth) -> Plane:
        """Return the true plane on cells of ``cell_px`` (of the truth's own step, if that is coarser)."""
        factor = max(1, self.cell_px // truth.step_px)
        obstacle_px = block_sum(truth.obstacle.astype(np.float32), factor)
        score = obstacle_px / block_sum(np.ones_like(truth.obstacle, np.float32), factor)
        obstacle = (score > self.threshold_ratio).astype(np.uint8)
        valid = block_sum(np.isfinite(truth.depth_m).astype(np.float32), factor) > 0
        return Plane(
            obstacle=obstacle,
            score=score,
            valid=valid.astype(np.uint8),
            step_px=factor * truth.step_px,
            obstacle_ratio=float(obstacle.sum() / max(np.count_nonzero(valid), 1)),
            threshold=self.threshold_ratio,
        )
