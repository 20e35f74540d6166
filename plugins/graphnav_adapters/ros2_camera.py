"""Adapters of what ROS 2 cameras publish: ``sensor_msgs/Image``, ``CompressedImage`` and ``CameraInfo``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from graphnav import CameraInfo, FieldError, Image, Ros2Adapter
from graphnav_adapters.pixels import Names, check_size, shape_of, without_padding

_ENCODINGS: Mapping[str, tuple[int, slice | None]] = {
    "mono8": (1, None),
    "8UC1": (1, None),
    "rgb8": (3, None),
    "bgr8": (3, slice(2, None, -1)),
    "rgba8": (4, slice(3)),
    "bgra8": (4, slice(2, None, -1)),
}
"""Channels of the encodings that are read, and those of red, green and blue where there are others or another order."""
_NAMES = Names("size of data", "height", "step")
_FRAME = "camera"


class RosImage(Ros2Adapter):
    """``sensor_msgs/Image`` to `Image` and back.

    Reads the encodings mono8, 8UC1, rgb8, bgr8, rgba8 and bgra8; rows may be padded (``step``, bytes). Writes mono8 or
    rgb8. The stamp is that of the header.
    """

    type_name = "sensor_msgs/Image"
    definition = """
std_msgs/Header header
uint32 height
uint32 width
string encoding
uint8 is_bigendian
uint32 step
uint8[] data
"""
    message = Image

    def from_ros(self, fields: Mapping[str, Any]) -> Image:
        """Return the picture: uint8, (rows, cols) or (rows, cols, 3) red-green-blue.

        Raises
        ------
        ValueError
            Size, step and data contradict each other, it has more than 64 million pixels, or its encoding is not read.
        """
        rows, cols, encoding = fields["height"], fields["width"], fields["encoding"]
        check_size(rows, cols)
        if encoding not in _ENCODINGS:
            raise FieldError("encoding", repr(encoding[:40]), ", ".join(_ENCODINGS))
        channels, order = _ENCODINGS[encoding]
        pixels = without_padding(fields["data"], rows, cols * channels, fields["step"], _NAMES)
        if channels == 1:
            return Image(pixels=pixels)
        colours = pixels.reshape(rows, cols, channels)
        return Image(pixels=colours if order is None else np.ascontiguousarray(colours[:, :, order]))

    def to_ros(self, message: Image, utime: int) -> Mapping[str, Any]:
        """Return the fields of a gray or red-green-blue picture."""
        rows, cols, channels = shape_of(message.pixels)
        return {
            "header": self.header(utime, _FRAME),
            "height": rows,
            "width": cols,
            "encoding": "mono8" if channels == 1 else "rgb8",
            "step": cols * channels,
            "data": message.pixels.reshape(-1),
        }


class RosCompressedImage(Ros2Adapter):
    """``sensor_msgs/CompressedImage`` to `Image` and back: JPEG, whatever ``format`` says. Stamps are of the header."""

    type_name = "sensor_msgs/CompressedImage"
    definition = """
std_msgs/Header header
string format
uint8[] data
"""
    message = Image

    def from_ros(self, fields: Mapping[str, Any]) -> Image:
        """Return the picture: uint8, (rows, cols) or (rows, cols, 3) red-green-blue.

        Raises
        ------
        ValueError
            It is not a JPEG, is truncated or damaged, or has more than 64 million pixels.
        """
        from graphnav_adapters.jpeg import decode_jpeg

        return Image(pixels=decode_jpeg(fields["data"].tobytes()))

    def to_ros(self, message: Image, utime: int) -> Mapping[str, Any]:
        """Return the fields of a gray or red-green-blue picture as JPEG."""
        from graphnav_adapters.jpeg import encode_jpeg

        shape_of(message.pixels)  # what a JPEG cannot hold is refused
        return {"header": self.header(utime, _FRAME), "format": "jpeg", "data": encode_jpeg(message.pixels)}


class RosCameraInfo(Ros2Adapter):
    """``sensor_msgs/CameraInfo`` to `CameraInfo` and back.

    Binning and region of interest are not read. The stamp is that of the header.
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
            "header": self.header(utime, _FRAME),
            "height": message.rows,
            "width": message.cols,
            "distortion_model": message.model,
            "d": message.distortion,
            "k": message.camera.reshape(-1),
            "r": message.rectification.reshape(-1),
            "p": message.projection.reshape(-1),
        }
