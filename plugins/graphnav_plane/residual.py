"""Dominant plane as what the planar flow explains."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from graphnav import Flow, Planar, Plane, Role
from graphnav_plane.detector import LEAST_VECTORS, Detector, all_ground, compared


class Residual(Detector):
    """Obstacle is where the flow differs from the planar flow: ``|u - û|``.

    The control for `plane.ica`: the same inputs without the separation. An ablation of ICA is believed only beside it.
    """

    role: ClassVar[Role] = "control"

    def step(self, flow: Flow, planar: Planar) -> Plane:
        """Return the plane on the grid of ``planar``; nothing is judged where fewer than 6 vectors are valid.

        Raises
        ------
        ValueError
            Flow and planar flow are of different image sizes.
        """
        cells, valid = compared(flow, planar)
        if np.count_nonzero(valid) < LEAST_VECTORS:
            return all_ground(valid.shape, cells.step_px)
        difference = cells.uv_px - planar.planar_uv_px
        return self._plane(np.hypot(difference[..., 0], difference[..., 1]), valid, cells.step_px)
