"""ROS messages as messages of graphnav.

Robots of graphnav drive on a plane: of a pose x, y and the heading are taken, of a velocity that forward and that
around the vertical axis.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from graphnav.core.messages import CameraInfo, FieldError, Image, Message, Odometry, Scan, Twist
from graphnav.core.record.bags.library import RawMessage
from graphnav.core.record.bags.ros_pictures import compressed_pixels, pixels_of
from graphnav.core.ros2 import STAMP_AT, time_us

_STAMPS = {True: struct.Struct("<iI"), False: struct.Struct(">iI")}
"""By whether the second byte of a message is not 0: it tells the byte order."""


class Reading(NamedTuple):
    """How a ROS type is read: as which message, and by which function; whether it begins with a header."""

    message: type[Message]
    convert: Callable[[Any], Message]
    has_header: bool = True


def _odometry(ros: Any) -> Odometry:
    position, turn, speeds = ros.pose.pose.position, ros.pose.pose.orientation, ros.twist.twist
    return Odometry(
        x_m=position.x,
        y_m=position.y,
        yaw_rad=_yaw_rad(turn),
        v_mps=speeds.linear.x,
        omega_radps=speeds.angular.z,
    )


def _yaw_rad(turn: Any) -> float:
    x, y, z, w = turn.x, turn.y, turn.z, turn.w
    if not x * x + y * y + z * z + w * w > 0.0:
        raise FieldError("pose.orientation", f"({x:g}, {y:g}, {z:g}, {w:g})", "a rotation")
    if x == y == 0.0:
        return 2.0 * math.atan2(z, w) if w >= 0.0 else 2.0 * math.atan2(-z, -w)
    return math.atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)


def _twist(ros: Any) -> Twist:
    return Twist(v_mps=ros.linear.x, omega_radps=ros.angular.z)


def _scan(ros: Any) -> Scan:
    return Scan.from_lcm_fields(
        {
            "angle_min_rad": ros.angle_min,
            "angle_increment_rad": ros.angle_increment,
            "range_min_m": ros.range_min,
            "range_max_m": ros.range_max,
            "ranges_m": np.asarray(ros.ranges, np.float32),
        }
    )


def _camera_info(ros: Any) -> CameraInfo:
    values = {"rows": ros.height, "cols": ros.width, "model": ros.distortion_model}
    values |= {"camera": ros.k.reshape(3, 3), "distortion": np.asarray(ros.d, np.float64)}
    values |= {"rectification": ros.r.reshape(3, 3), "projection": ros.p.reshape(3, 4)}
    return CameraInfo.from_lcm_fields(values)


READ: dict[str, Reading] = {
    "sensor_msgs/msg/Image": Reading(Image, lambda ros: Image(pixels=pixels_of(ros))),
    "sensor_msgs/msg/CompressedImage": Reading(Image, lambda ros: Image(pixels=compressed_pixels(ros))),
    "sensor_msgs/msg/CameraInfo": Reading(CameraInfo, _camera_info),
    "nav_msgs/msg/Odometry": Reading(Odometry, _odometry),
    "geometry_msgs/msg/TwistStamped": Reading(Twist, lambda ros: _twist(ros.twist)),
    "geometry_msgs/msg/Twist": Reading(Twist, _twist, has_header=False),
    "sensor_msgs/msg/LaserScan": Reading(Scan, _scan),
}
"""The ROS types that are read."""


def stamp_us(raw: RawMessage, data: bytes) -> int:
    """Return the stamp of a message's header, microseconds; without one, or a stamp of 0, when it was recorded."""
    found = READ.get(raw.ros_type)
    if found is None or not found.has_header or len(data) < STAMP_AT + _STAMPS[True].size:
        return raw.logged_ns // 1000
    return time_us(*_STAMPS[bool(data[1])].unpack_from(data, STAMP_AT)) or raw.logged_ns // 1000
