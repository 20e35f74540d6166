"""Steering to the gap in the picture: free ways without knowing where the camera is mounted."""

from __future__ import annotations

import math

import cv2
import numpy as np

from graphnav import Goal, Latest, ParamError, Plane, Stage, Steering, param
from graphnav.arrays import Bytes, Doubles
from graphnav_steer.headings import headed
from graphnav_steer.longest_way import Costs, LongestWay
from graphnav_steer.unjudged import RIM_DOC, UNJUDGED_DOC, Unjudged, with_unjudged


class PictureGap(Stage):
    """Heads for the gap in the picture: the direction of the longest free way, less the cost of turning there.

    As `steer.gap`, but in the picture instead of on a map: it knows neither height nor tilt of the camera, and
    remembers nothing. Two shares of the picture, which one can measure in it, take their place: where the robot stands,
    and how wide it is on the floor. Ways begin where it stands. Along each direction the way is free as long as no
    obstacle is nearer than half of its width; a way that is longer than up to the upper border counts as this long.
    Floor behind an obstacle is not reached, and beyond the picture nothing is known.

    It suits cameras that look down: the picture's directions are then those of the floor.
    """

    foot_ratio: float = param(
        0.75,
        gt=0.0,
        le=1.0,
        doc="where the robot stands in the picture's middle column: distance from the upper border as a share of the "
        "height; 1 where it is below the picture",
    )
    width_ratio: float = param(
        0.33,
        gt=0.0,
        le=1.0,
        doc="width on the floor that the robot needs, with a margin, as a share of the picture's width",
    )
    unjudged: Unjudged = param("obstacle", doc=UNJUDGED_DOC)
    rim_ratio: float = param(Plane.RIM_RATIO, ge=0.0, le=0.4, doc=RIM_DOC)
    min_way_ratio: float = param(
        0.35, ge=0.0, le=1.0, doc="with no direction free for this share of the picture's height the robot turns"
    )
    turn_cost_ratio: float = param(0.5, ge=0.0, le=100.0, doc="cost of turning by half a circle, in picture heights")
    change_cost_ratio: float = param(
        0.5, ge=0.0, le=100.0, doc="cost of a direction at half a circle from the last choice, in picture heights"
    )
    goal_cost_ratio: float = param(
        1.0, ge=0.0, le=100.0, doc="cost of a direction at half a circle from the goal, in picture heights"
    )
    headings: int = param(37, ge=5, le=361, doc="number of directions from left to right")

    def check(self) -> None:
        """Check that a way can be as long as the robot wants it."""
        if self.min_way_ratio >= self.foot_ratio:
            what = f"'min_way_ratio' {self.min_way_ratio:g} is not less than 'foot_ratio' {self.foot_ratio:g}"
            raise ParamError("min_way_ratio", f"{what}: the robot would only turn", "make it less")

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Forget the last choice."""
        self._headings_rad = np.linspace(math.pi / 2, -math.pi / 2, self.headings)
        costs = Costs(self.turn_cost_ratio, self.change_cost_ratio, self.goal_cost_ratio)
        self._longest = LongestWay(self._headings_rad, self.min_way_ratio, costs)

    def step(self, plane: Plane, goal: Latest[Goal]) -> Steering:
        """Return the steering towards the chosen direction: no repulsive force, a guiding force of length 1."""
        obstacle, _ = with_unjudged(plane, self.unjudged, self.rim_ratio)
        goal_rad = None if goal.value is None else goal.value.bearing_rad
        return headed(self._longest.theta_rad(self._ways(obstacle), goal_rad))

    def _ways(self, obstacle: Bytes) -> Doubles:
        """Return the free way of each direction as shares of the picture's height, at most that ahead, (headings,)."""
        rows, cols = obstacle.shape
        clearance = cv2.distanceTransform((obstacle == 0).view(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
        steps = np.arange(0.5, rows, 0.5)
        row = np.floor(self.foot_ratio * rows - np.outer(np.cos(self._headings_rad), steps)).astype(np.intp)
        col = np.floor(cols / 2 - np.outer(np.sin(self._headings_rad), steps)).astype(np.intp)
        inside = (row >= 0) & (row < rows) & (col >= 0) & (col < cols)
        near = clearance[np.clip(row, 0, rows - 1), np.clip(col, 0, cols - 1)]
        wanted = np.minimum(self.width_ratio * cols / 2, near[:, :1])
        free = np.logical_and.accumulate(inside & (near >= wanted), axis=1)
        return np.asarray(np.minimum(free.sum(axis=1) / (2.0 * rows), self.foot_ratio - 0.5 / rows))
