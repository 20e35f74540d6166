"""Ground everywhere: the baseline without information."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from graphnav import Flow, Plane, Role, Stage, coarsen, param


class AllGround(Stage):
    """Baseline: every cell with a vector is ground, and all score alike.

    Its AUROC and its balanced accuracy are 0.5 in every world: a detector contributes what it gains over this baseline.
    """

    role: ClassVar[Role] = "baseline"

    cell_px: int = param(4, ge=1, le=4096, doc="side of the pixel blocks that become one cell")

    def step(self, flow: Flow) -> Plane:
        """Return ground on cells of ``cell_px`` (of the flow's own step, if that is coarser)."""
        cells = coarsen(flow, max(self.cell_px, flow.step_px))
        return Plane(
            obstacle=np.zeros_like(cells.valid),
            score=np.zeros(cells.valid.shape, np.float32),
            valid=cells.valid,
            step_px=cells.step_px,
            obstacle_ratio=0.0,
        )
