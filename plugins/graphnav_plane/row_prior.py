"""Obstacle by height in the picture: the baseline that ignores the flow."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from graphnav import Flow, Plane, Role, Stage, coarsen, param


class RowPrior(Stage):
    """Baseline: the higher a cell is in the picture, the more it counts as obstacle, regardless of the flow.

    Distant things are high in the picture, and more often obstacle than the floor before the robot's wheels: a
    forward-looking camera gives this baseline a high AUROC. A detector contributes what it adds.
    """

    role: ClassVar[Role] = "baseline"

    cell_px: int = param(4, ge=1, le=4096, doc="side of the pixel blocks that become one cell")
    horizon_ratio: float = param(
        0.25, ge=0.0, le=1.0, doc="share of the picture's rows, from the top, that are obstacle"
    )

    def step(self, flow: Flow) -> Plane:
        """Return the plane on cells of ``cell_px`` (of the flow's own step, if that is coarser)."""
        cells = coarsen(flow, max(self.cell_px, flow.step_px))
        valid = cells.valid != 0
        rows = valid.shape[0]
        height = 1 - (np.arange(rows) + 0.5) / rows
        score = np.where(valid, height[:, None], 0.0).astype(np.float32)
        threshold = 1 - self.horizon_ratio
        obstacle = (score > threshold) & valid
        return Plane(
            obstacle=obstacle.astype(np.uint8),
            score=score,
            valid=valid.astype(np.uint8),
            step_px=cells.step_px,
            obstacle_ratio=float(obstacle.sum() / max(np.count_nonzero(valid), 1)),
            threshold=threshold,
        )
