"""Poses in the plane, and arcs of constant twist between them."""

from __future__ import annotations

import math
from typing import NamedTuple


class Pose(NamedTuple):
    """Position in metres and heading in radians, counterclockwise, not wrapped."""

    x_m: float
    y_m: float
    yaw_rad: float

    def seen_from(self, other: Pose) -> Pose:
        """Return this pose in the frame of ``other``."""
        x, y = self.x_m - other.x_m, self.y_m - other.y_m
        c, s = math.cos(other.yaw_rad), math.sin(other.yaw_rad)
        return Pose(c * x + s * y, c * y - s * x, self.yaw_rad - other.yaw_rad)

    def then(self, step: Pose) -> Pose:
        """Return ``step``, a pose in the frame of this one, in the parent frame."""
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        return Pose(
            self.x_m + c * step.x_m - s * step.y_m,
            self.y_m + s * step.x_m + c * step.y_m,
            self.yaw_rad + step.yaw_rad,
        )


def arc(forward_m: float, left_m: float, turn_rad: float) -> Pose:
    """Return the end pose of a motion of constant twist from the origin, heading along x.

    ``forward_m``, ``left_m``: displacement along the robot's own axes; ``turn_rad``: the turn during it.
    """
    a, b = _chord(turn_rad)
    return Pose(a * forward_m - b * left_m, b * forward_m + a * left_m, turn_rad)


def part_of_arc(end: Pose, share: float) -> Pose:
    """Return the pose at ``share`` (0 to 1) of the arc of constant twist from the origin to ``end``."""
    a, b = _chord(end.yaw_rad)
    size = a * a + b * b
    forward_m, left_m = (a * end.x_m + b * end.y_m) / size, (a * end.y_m - b * end.x_m) / size
    return arc(share * forward_m, share * left_m, share * end.yaw_rad)


def _chord(turn_rad: float) -> tuple[float, float]:
    """Return sin(t) / t and (1 - cos(t)) / t."""
    if turn_rad == 0.0:
        return 1.0, 0.0
    return math.sin(turn_rad) / turn_rad, 2.0 * math.sin(turn_rad / 2.0) ** 2 / turn_rad
