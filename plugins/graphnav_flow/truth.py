"""The simulator's true flow in place of an estimate."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

import graphnav
from graphnav import Flow, Role, Stage, param
from graphnav_flow.validity import MARGIN_DOC, MARGIN_PX, Inside


class Truth(Stage):
    """The simulator's true flow, valid by the estimators' rule; isolates the error of the flow.

    The texture is not checked, because the truth does not depend on it. Nothing is valid above the horizon.
    """

    role: ClassVar[Role] = "oracle"

    margin_px: float = param(MARGIN_PX, ge=0.0, le=100_000.0, doc=MARGIN_DOC)

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Forget the size of the images."""
        self._inside: Inside | None = None

    def step(self, truth: graphnav.Truth) -> Flow:
        """Return the true flow since the last image."""
        if self._inside is None:
            rows, cols = truth.depth_m.shape
            self._inside = Inside(rows, cols, self.margin_px)
        valid = self._inside.mark(truth.flow_px)
        valid &= np.isfinite(truth.depth_m)
        return Flow(
            uv_px=truth.flow_px, valid=valid.view(np.uint8), interval_us=truth.interval_us, step_px=truth.step_px
        )
