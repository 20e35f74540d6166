"""Adapters of ROS 2 poses, commands, stops and maps."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from graphnav import FieldError, LocalMap, Odometry, Ros2Adapter, Stop, Twist

_BASE, _ODOMETRY = "base_link", "odom"
_MAX_NORM_ERROR = 0.01
_OCCUPANCY = np.array([-1, 0, 100, 100], np.int8)
"""Of the states of a `LocalMap`: unknown, free, obstacle, moving obstacle."""
_MAP_META_DATA = """
===
MSG: nav_msgs/MapMetaData
builtin_interfaces/Time map_load_time
float32 resolution
uint32 width
uint32 height
geometry_msgs/Pose origin
"""


class RosOdometry(Ros2Adapter):
    """``nav_msgs/Odometry`` to `Odometry` and back: position, yaw, forward speed and turning rate in the plane."""

    type_name = "nav_msgs/Odometry"
    definition = """
std_msgs/Header header
string child_frame_id
geometry_msgs/PoseWithCovariance pose
geometry_msgs/TwistWithCovariance twist
"""
    message = Odometry

    def from_ros(self, fields: Mapping[str, Any]) -> Odometry:
        """Return pose and speeds.

        Raises
        ------
        ValueError
            The orientation is not a unit quaternion.
        """
        pose, twist = fields["pose"]["pose"], fields["twist"]["twist"]
        x, y, z, w = (pose["orientation"][axis] for axis in "xyzw")
        norm = math.hypot(x, y, z, w)
        if not abs(norm - 1.0) <= _MAX_NORM_ERROR:
            raise FieldError("norm of pose.pose.orientation", norm, "1")
        yaw_rad = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        position, speed = pose["position"], twist["linear"]["x"]
        return Odometry(
            x_m=position["x"], y_m=position["y"], yaw_rad=yaw_rad, v_mps=speed, omega_radps=twist["angular"]["z"]
        )

    def to_ros(self, message: Odometry, utime: int) -> Mapping[str, Any]:
        """Return pose and speeds, with covariances of zero: unknown."""
        return {
            "header": self.header(utime, _ODOMETRY),
            "child_frame_id": _BASE,
            "pose": {"pose": _pose(message.x_m, message.y_m, message.yaw_rad)},
            "twist": {"twist": _twist(message)},
        }


class RosTwist(Ros2Adapter):
    """``geometry_msgs/Twist`` to `Twist` and back: ``linear.x`` and ``angular.z``. It has no stamp."""

    type_name = "geometry_msgs/Twist"
    definition = "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular"
    message = Twist

    def from_ros(self, fields: Mapping[str, Any]) -> Twist:
        """Return forward speed and turning rate."""
        return Twist(v_mps=fields["linear"]["x"], omega_radps=fields["angular"]["z"])

    def to_ros(self, message: Twist, utime: int) -> Mapping[str, Any]:
        """Return forward speed and turning rate; all else is zero."""
        del utime
        return _twist(message)


class RosTwistStamped(Ros2Adapter):
    """``geometry_msgs/TwistStamped`` to `Twist` and back, as `RosTwist`; the stamp is that of the header."""

    type_name = "geometry_msgs/TwistStamped"
    definition = "std_msgs/Header header\ngeometry_msgs/Twist twist"
    message = Twist

    def from_ros(self, fields: Mapping[str, Any]) -> Twist:
        """Return forward speed and turning rate."""
        return Twist(v_mps=fields["twist"]["linear"]["x"], omega_radps=fields["twist"]["angular"]["z"])

    def to_ros(self, message: Twist, utime: int) -> Mapping[str, Any]:
        """Return forward speed and turning rate; all else is zero."""
        return {"header": self.header(utime, _BASE), "twist": _twist(message)}


class RosBool(Ros2Adapter):
    """``std_msgs/Bool`` to `Stop` and back: true stops, false arms."""

    type_name = "std_msgs/Bool"
    definition = "bool data"
    message = Stop

    def from_ros(self, fields: Mapping[str, Any]) -> Stop:
        """Return the stop."""
        return Stop(engaged=fields["data"], reason=self.type_name)

    def to_ros(self, message: Stop, utime: int) -> Mapping[str, Any]:
        """Return whether it is engaged; its reason is lost."""
        del utime
        return {"data": message.engaged}


class RosOccupancyGrid(Ros2Adapter):
    """`LocalMap` to ``nav_msgs/OccupancyGrid``: -1 unknown, 0 free, 100 an obstacle, standing or moving.

    Who subscribes later gets the last one, too, as ROS programs expect of a map.
    """

    type_name = "nav_msgs/OccupancyGrid"
    definition = "std_msgs/Header header\nnav_msgs/MapMetaData info\nint8[] data" + _MAP_META_DATA
    message = LocalMap
    latched = True

    def to_ros(self, message: LocalMap, utime: int) -> Mapping[str, Any]:
        """Return the map in the frame ``odom``, whose origin is the pose of the robot at the start."""
        rows, cols = message.state.shape
        half_m = 0.5 * message.cell_m
        header = self.header(utime, _ODOMETRY)
        return {
            "header": header,
            "info": {
                "map_load_time": header["stamp"],
                "resolution": message.cell_m,
                "width": cols,
                "height": rows,
                "origin": _pose(message.origin_x_m - half_m, message.origin_y_m - half_m, 0.0),
            },
            "data": _OCCUPANCY[np.clip(message.state, 0, 3)].reshape(-1),
        }


def _pose(x_m: float, y_m: float, yaw_rad: float) -> Mapping[str, Any]:
    half_rad = 0.5 * yaw_rad
    return {
        "position": {"x": x_m, "y": y_m},
        "orientation": {"z": math.sin(half_rad), "w": math.cos(half_rad)},
    }


def _twist(message: Twist | Odometry) -> Mapping[str, Any]:
    return {"linear": {"x": message.v_mps}, "angular": {"z": message.omega_radps}}
