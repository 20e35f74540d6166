"""Messages of graphnav as ROS messages of standard types.

Frames: ``base_link`` of the robot (x forward, y left), ``odom`` of odometry and of the local map, ``map`` of the true
pose, ``camera`` of images.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from graphnav.core.messages import (
    CameraInfo,
    Goal,
    Image,
    LocalMap,
    Message,
    Odometry,
    Scan,
    State,
    Steering,
    Stop,
    Twist,
)
from graphnav.core.record.bags.library import Cdr
from graphnav.core.ros2 import time_fields

_ROBOT, _ODOMETRY, _WORLD, _CAMERA = "base_link", "odom", "map", "camera"
_OCCUPANCY = {LocalMap.UNKNOWN: -1, LocalMap.FREE: 0, LocalMap.OBSTACLE: 100, LocalMap.MOVING: 100}
"""Of ``nav_msgs/OccupancyGrid``: probabilities in percent, -1 unknown."""


class Writing(NamedTuple):
    """How a message is written: as which ROS type, and by which function of the message and its stamp."""

    ros_type: str
    convert: Callable[[RosMessages, Any, int], Any]


class RosMessages:
    """Makes ROS messages."""

    def __init__(self, cdr: Cdr) -> None:
        self.make = cdr.make

    def header(self, utime: int, frame: str) -> Any:
        """Return a header with a stamp in microseconds."""
        stamp = self.make("builtin_interfaces/msg/Time", **time_fields(utime))
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id=frame)

    def vector(self, kind: str, x: float, y: float, z: float) -> Any:
        """Return a ``Vector3`` or ``Point``."""
        return self.make(f"geometry_msgs/msg/{kind}", x=float(x), y=float(y), z=float(z))

    def pose(self, x_m: float, y_m: float, yaw_rad: float) -> Any:
        """Return a pose on the plane."""
        half = yaw_rad / 2.0
        turn = self.make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=math.sin(half), w=math.cos(half))
        return self.make("geometry_msgs/msg/Pose", position=self.vector("Point", x_m, y_m, 0.0), orientation=turn)

    def twist(self, v_mps: float, omega_radps: float) -> Any:
        """Return a velocity on the plane."""
        linear, angular = self.vector("Vector3", v_mps, 0.0, 0.0), self.vector("Vector3", 0.0, 0.0, omega_radps)
        return self.make("geometry_msgs/msg/Twist", linear=linear, angular=angular)


def _camera_info(ros: RosMessages, info: CameraInfo, utime: int) -> Any:
    return ros.make(
        "sensor_msgs/msg/CameraInfo",
        header=ros.header(utime, _CAMERA),
        height=info.rows,
        width=info.cols,
        distortion_model=info.model,
        d=np.asarray(info.distortion, np.float64),
        k=np.asarray(info.camera, np.float64).reshape(-1),
        r=np.asarray(info.rectification, np.float64).reshape(-1),
        p=np.asarray(info.projection, np.float64).reshape(-1),
        binning_x=0,
        binning_y=0,
        roi=ros.make("sensor_msgs/msg/RegionOfInterest", x_offset=0, y_offset=0, height=0, width=0, do_rectify=False),
    )


def _image(ros: RosMessages, image: Image, utime: int) -> Any:
    rows, cols = image.pixels.shape[:2]
    n_channels = 1 if image.pixels.ndim == 2 else 3
    return ros.make(
        "sensor_msgs/msg/Image",
        header=ros.header(utime, _CAMERA),
        height=rows,
        width=cols,
        encoding="mono8" if n_channels == 1 else "rgb8",
        is_bigendian=0,
        step=cols * n_channels,
        data=np.ascontiguousarray(image.pixels).reshape(-1),
    )


def _twist(ros: RosMessages, twist: Twist, utime: int) -> Any:
    header, speeds = ros.header(utime, _ROBOT), ros.twist(twist.v_mps, twist.omega_radps)
    return ros.make("geometry_msgs/msg/TwistStamped", header=header, twist=speeds)


def _odometry(frame: str) -> Callable[[RosMessages, Any, int], Any]:
    def convert(ros: RosMessages, state: Odometry | State, utime: int) -> Any:
        pose = ros.pose(state.x_m, state.y_m, state.yaw_rad)
        twist = ros.twist(state.v_mps, state.omega_radps)
        unknown = np.zeros(36)
        return ros.make(
            "nav_msgs/msg/Odometry",
            header=ros.header(utime, frame),
            child_frame_id=_ROBOT,
            pose=ros.make("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=unknown),
            twist=ros.make("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=unknown),
        )

    return convert


def _grid(ros: RosMessages, grid: LocalMap, utime: int) -> Any:
    header = ros.header(utime, _ODOMETRY)
    rows, cols = grid.state.shape
    half_m = grid.cell_m / 2.0  # ROS has the corner of the first cell, graphnav its middle
    info = ros.make(
        "nav_msgs/msg/MapMetaData",
        map_load_time=header.stamp,
        resolution=grid.cell_m,
        width=cols,
        height=rows,
        origin=ros.pose(grid.origin_x_m - half_m, grid.origin_y_m - half_m, 0.0),
    )
    values = np.array([_OCCUPANCY[state] for state in range(len(_OCCUPANCY))], np.int8)[grid.state].reshape(-1)
    return ros.make("nav_msgs/msg/OccupancyGrid", header=header, info=info, data=values)


def _scan(ros: RosMessages, scan: Scan, utime: int) -> Any:
    last = len(scan.ranges_m) - 1
    return ros.make(
        "sensor_msgs/msg/LaserScan",
        header=ros.header(utime, _ROBOT),
        angle_min=scan.angle_min_rad,
        angle_max=scan.angle_min_rad + last * scan.angle_increment_rad,
        angle_increment=scan.angle_increment_rad,
        time_increment=0.0,
        scan_time=0.0,
        range_min=scan.range_min_m,
        range_max=scan.range_max_m,
        ranges=np.asarray(scan.ranges_m, np.float32),
        intensities=np.zeros(0, np.float32),
    )


def _goal(ros: RosMessages, goal: Goal, utime: int) -> Any:
    x_m, y_m = goal.distance_m * math.cos(goal.bearing_rad), goal.distance_m * math.sin(goal.bearing_rad)
    point = ros.vector("Point", x_m, y_m, 0.0)
    return ros.make("geometry_msgs/msg/PointStamped", header=ros.header(utime, _ROBOT), point=point)


def _direction(ros: RosMessages, steering: Steering, utime: int) -> Any:  # noqa: ARG001 - it has no header
    return ros.make("std_msgs/msg/Float64", data=float(steering.theta_rad))


def _stop(ros: RosMessages, stop: Stop, utime: int) -> Any:  # noqa: ARG001 - it has no header
    return ros.make("std_msgs/msg/Bool", data=bool(stop.engaged))


WRITTEN: dict[type[Message], Writing] = {
    Image: Writing("sensor_msgs/msg/Image", _image),
    CameraInfo: Writing("sensor_msgs/msg/CameraInfo", _camera_info),
    Twist: Writing("geometry_msgs/msg/TwistStamped", _twist),
    Odometry: Writing("nav_msgs/msg/Odometry", _odometry(_ODOMETRY)),
    State: Writing("nav_msgs/msg/Odometry", _odometry(_WORLD)),
    LocalMap: Writing("nav_msgs/msg/OccupancyGrid", _grid),
    Scan: Writing("sensor_msgs/msg/LaserScan", _scan),
    Goal: Writing("geometry_msgs/msg/PointStamped", _goal),
    Steering: Writing("std_msgs/msg/Float64", _direction),
    Stop: Writing("std_msgs/msg/Bool", _stop),
}
"""The messages that have a standard ROS type: of `Steering` the direction, of `Stop` whether it is engaged."""
