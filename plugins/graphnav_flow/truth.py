"""The simulator's true flow, as if it had been estimated."""

from __future__ import annotations

import graphnav
from graphnav import Flow, Stage, param
from graphnav_flow.validity import came_from_inside


class Truth(Stage):
    """The simulator's true flow, valid by the estimators' own rule; it isolates the error of the flow.

    Texture plays no part, because the truth needs none. A truth that covers no time, the first, gives no flow.
    """

    margin_px: float = param(4.0, ge=0.0, doc="vectors from or at places nearer to the border than this are not valid")

    def step(self, truth: graphnav.Truth) -> Flow | None:
        """Return the flow since the last image, None for the first."""
        if truth.interval_us == 0:
            return None
        valid = came_from_inside(truth.flow_px, self.margin_px)
        return Flow(uv_px=truth.flow_px, valid=valid, interval_us=truth.interval_us, step_px=truth.step_px)
