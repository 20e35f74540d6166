"""A score of small obstacles: how much of them is found, by their share of the view, and what an empty floor gets."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

import graphnav
from graphnav import Role, Stage, Truth, block_sum, hookimpl

SHARES = ((0.01, 0.03), (0.03, 0.1))
_MIN_MOTION_PX = 0.1


class SmallObstacles(Stage):
    """Count obstacle pixels found and missed, and ground that is called obstacle.

    ``hit``, ``total``: (2,), obstacle pixels of the frames of each of `SHARES`; what was not judged is missed.
    ``false``, ``ground``: judged pixels of the frames without an obstacle.
    """

    role: ClassVar[Role] = "score"

    def reset(self, seed: int) -> None:
        """Forget everything counted."""
        self.hit, self.total = np.zeros((2, len(SHARES)))
        self.false = self.ground = 0.0

    def step(self, plane: graphnav.Plane, truth: Truth) -> None:
        """Count this frame, unless nothing moves."""
        if np.abs(truth.flow_px).max() < _MIN_MOTION_PX:
            return
        factor = plane.step_px // truth.step_px
        is_obstacle = truth.obstacle != 0
        obstacle = block_sum(is_obstacle.astype(np.float32), factor)
        called = plane.obstacle != 0
        share = float(is_obstacle.mean())
        if not share:
            ground = block_sum(np.isfinite(truth.depth_m).astype(np.float32), factor)
            self.false += float(ground[called].sum())
            self.ground += float(ground[plane.valid != 0].sum())
        for place, (low, high) in enumerate(SHARES):
            if low <= share < high:
                self.hit[place] += float(obstacle[called].sum())
                self.total[place] += float(obstacle.sum())


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stage of this file."""
    return [SmallObstacles]
