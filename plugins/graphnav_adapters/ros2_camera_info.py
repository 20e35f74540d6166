"""Adapter of ROS 2 camera parameters: ``sensor_msgs/CameraInfo``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from graphnav import CameraInfo, Ros2Adapter
from graphnav_adapters.ros2_header import header

_FRAME = "camera"


class RosCameraInfo(Ros2Adapter):
    """``sensor_msgs/CameraInfo`` to `CameraInfo` and back; binning and region of interest are those of no driver read.

    The stamp is that of the header.
    """

    type_name = "sensor_msgs/CameraInfo"
    definition = """
std_msgs/Header header
uint32 height
uint32 width
string distortion_model
float64[] d
float64[9] k
float64[9] r
float64[12] p
uint32 binning_x
uint32 binning_y
sensor_msgs/RegionOfInterest roi
===
MSG: sensor_msgs/RegionOfInterest
uint32 x_offset
uint32 y_offset
uint32 height
uint32 width
bool do_rectify
"""
    message = CameraInfo

    def from_ros(self, fields: Mapping[str, Any]) -> CameraInfo:
        """Return the parameters.

        Raises
        ------
        ValueError
            The model is not known, has not so many coefficients, or the camera is not calibrated.
        """
        values = {
            "rows": fields["height"],
            "cols": fields["width"],
            "model": fields["distortion_model"],
            "camera": np.array(fields["k"], np.float64).reshape(3, 3),
            "distortion": np.array(fields["d"], np.float64),
            "rectification": np.array(fields["r"], np.float64).reshape(3, 3),
            "projection": np.array(fields["p"], np.float64).reshape(3, 4),
        }
        return CameraInfo.from_lcm_fields(values)

    def to_ros(self, message: CameraInfo, utime: int) -> Mapping[str, Any]:
        """Return the fields, without binning and for the complete picture."""
        return {
            "header": header(utime, _FRAME),
            "height": message.rows,
            "width": message.cols,
            "distortion_model": message.model,
            "d": message.distortion,
            "k": message.camera.reshape(-1),
            "r": message.rectification.reshape(-1),
            "p": message.projection.reshape(-1),
        }
