"""Whether steering points to the freer side."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

import graphnav
from graphnav import Stage, Truth, param


class Steering(Stage):
    """Share of frames in which the control force points to the side with less true obstacle.

    Only frames count in which the shares of the picture that are obstacle in its left and in its right half differ
    clearly. No force to either side counts as wrong. Figures: ``frames`` that counted, and ``right_sign_ratio``, left
    out where there is no such frame.
    """

    least_times: float = param(2.0, ge=1.0, doc="a frame counts if one half holds at least so many times the other's")
    least_difference_ratio: float = param(
        0.05, gt=0.0, le=0.5, doc="and if they differ by at least this share of the picture"
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Forget everything counted."""
        self._frames = self._right = 0

    def step(self, steering: graphnav.Steering, truth: Truth) -> None:
        """Count this frame."""
        half = truth.obstacle.shape[1] // 2
        is_obstacle = truth.obstacle != 0
        left = np.count_nonzero(is_obstacle[:, :half]) / is_obstacle.size
        right = np.count_nonzero(is_obstacle[:, is_obstacle.shape[1] - half :]) / is_obstacle.size
        clear = max(left, right) >= self.least_times * min(left, right)
        if not clear or abs(left - right) < self.least_difference_ratio:
            return
        self._frames += 1
        to_the_right = float(steering.control[0])
        self._right += to_the_right > 0 if left > right else to_the_right < 0

    def summary(self) -> Mapping[str, float]:
        """Return the figures that are defined."""
        figures = {"frames": float(self._frames)}
        if self._frames:
            figures["right_sign_ratio"] = self._right / self._frames
        return figures
