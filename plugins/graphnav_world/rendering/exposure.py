"""Poses of the robot while the shutter is open."""

from __future__ import annotations

import math

from graphnav_world.vehicle import Pose

VIEWS = 5
"""Number of views averaged in a blurred picture, the frame's own in the middle; they must be few pixels apart."""


def moments(exposure_s: float) -> list[float]:
    """Return the other moments of an exposure around a frame: seconds after it. None without an exposure."""
    if exposure_s == 0.0:
        return []
    middle = VIEWS // 2
    return [exposure_s * (k - middle) / VIEWS for k in range(VIEWS) if k != middle]


def driven(pose: Pose, after_s: float) -> tuple[float, float, float]:
    """Return the robot's (x, y, yaw) so long after a frame; it keeps the speeds that it has in the frame."""
    way_m, turn_rad = pose.v_mps * after_s, pose.omega_radps * after_s
    heading = pose.yaw_rad + turn_rad / 2
    return pose.x_m + way_m * math.cos(heading), pose.y_m + way_m * math.sin(heading), pose.yaw_rad + turn_rad
