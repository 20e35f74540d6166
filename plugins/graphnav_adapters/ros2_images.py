"""Adapters of ROS 2 pictures: ``sensor_msgs/Image`` and ``sensor_msgs/CompressedImage``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from graphnav import FieldError, Image, Ros2Adapter
from graphnav.arrays import Bytes
from graphnav_adapters.max_pixels import check_size
from graphnav_adapters.padded_rows import Names, without_padding
from graphnav_adapters.ros2_header import header

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
        rows, cols, channels = _shape(message.pixels)
        return {
            "header": header(utime, _FRAME),
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

        _shape(message.pixels)
        return {"header": header(utime, _FRAME), "format": "jpeg", "data": encode_jpeg(message.pixels)}


def _shape(pixels: Bytes) -> tuple[int, int, int]:
    """Return rows, columns and channels; raises ValueError for a picture that is neither gray nor red-green-blue."""
    if pixels.ndim == 2:
        return (*pixels.shape, 1)
    if pixels.ndim != 3 or pixels.shape[2] != 3:
        raise ValueError(f"pixels of shape {pixels.shape} are neither (rows, cols) nor (rows, cols, 3)")
    return (*pixels.shape[:2], 3)
