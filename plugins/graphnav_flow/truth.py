"""The simulator's true flow in place of an estimate."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

import graphnav
from graphnav import Flow, Role, Stage, param
from graphnav_flow.validity import MARGIN_DOC, MARGIN_PX, came_from_inside


class Truth(Stage):
    """The simulator's true flow, valid by the estimators' rule; isolates the error of the flow.

    The texture is not checked, because the truth does not depend on it. Nothing is valid above the horizon.
    """

    role: ClassVar[Role] = "oracle"

    margin_px: float = param(MARGIN_PX, ge=0.0, doc=MARGIN_DOC)

    def step(self, truth: graphnav.Truth) -> Flow:
        """Return the true flow since the last image."""
        valid = came_from_inside(truth.flow_px, self.margin_px) & np.isfinite(truth.depth_m)
        return Flow(uv_px=truth.flow_px, valid=valid, interval_us=truth.interval_us, step_px=truth.step_px)
