"""Dominant plane by the difference between flow and planar flow."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from graphnav import Flow, Planar, Plane, Role, Stamp
from graphnav.arrays import Bools, Floats
from graphnav_plane.detector import MIN_VECTORS, Detector, compared


class Residual(Detector):
    """Obstacle is where the flow differs from the planar flow: ``|u - û|``.

    The baseline of `plane.ica`: the same inputs without the separation. An ablation of ICA needs it for comparison.
    """

    role: ClassVar[Role] = "baseline"

    def step(self, flow: Flow, planar: Planar, stamp: Stamp) -> Plane:
        """Return the plane on the grid of ``planar``; nothing is judged where fewer than 6 vectors are valid.

        Raises
        ------
        ValueError
            Flow and planar flow are of different image sizes or cover different times.
        """
        self._begin(stamp)
        cells, valid = compared(flow, planar)
        if np.count_nonzero(valid) < MIN_VECTORS:
            return self._unjudged(cells)
        left_px = cells.uv_px - self._ground_px(cells.uv_px, planar.planar_uv_px, valid)
        return self._plane(self._remembered(left_px, valid, cells), valid, cells.step_px)

    def _ground_px(self, flow_px: Floats, planar_px: Floats, valid: Bools) -> Floats:  # noqa: ARG002
        """Return the flow that the ground has, (rows, cols, 2): the planar flow as it is."""
        return planar_px
