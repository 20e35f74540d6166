"""The pixels of ROS images, raw and compressed."""

from __future__ import annotations

import io
import warnings
from typing import Any

import numpy as np

from graphnav.arrays import Bytes
from graphnav.core.messages import FieldError

MAX_PIXELS = 64_000_000
"""More than any robot camera has; a larger declared size is refused before memory is allocated."""
_CHANNELS = {"mono8": 1, "8UC1": 1, "rgb8": 3, "bgr8": 3, "rgba8": 4, "bgra8": 4}
"""By encoding: the bytes of a pixel."""


def pixels_of(ros: Any) -> Bytes:
    """Return the pixels of ``sensor_msgs/Image``: uint8, (rows, cols) or (rows, cols, 3) red-green-blue.

    Raises
    ------
    FieldError
        The encoding is not one of 8 bits, gray or colour, or the sizes contradict each other.
    """
    n_channels = _CHANNELS.get(ros.encoding)
    if n_channels is None:
        raise FieldError("encoding", f"'{ros.encoding}'", ", ".join(_CHANNELS))
    rows, cols, row_bytes = int(ros.height), int(ros.width), int(ros.step)
    _check_size(rows, cols)
    if row_bytes < cols * n_channels:
        raise FieldError("step", row_bytes, f"{cols * n_channels} or more, the bytes of a row")
    if len(ros.data) != rows * row_bytes:
        raise FieldError("size of data", len(ros.data), f"height * step = {rows} * {row_bytes} = {rows * row_bytes}")
    data: Bytes = np.asarray(ros.data, np.uint8).reshape(rows, row_bytes)[:, : cols * n_channels]
    if n_channels == 1:
        return np.ascontiguousarray(data)
    colours = data.reshape(rows, cols, n_channels)
    return np.ascontiguousarray(colours[:, :, 2::-1] if ros.encoding.startswith("bgr") else colours[:, :, :3])


def compressed_pixels(ros: Any) -> Bytes:
    """Return the pixels of ``sensor_msgs/CompressedImage``, a JPEG or PNG of 8 bits, as `pixels_of` does.

    Raises
    ------
    FieldError
        It is larger than any camera's.
    ValueError
        It is not JPEG or PNG, or damaged.
    """
    from PIL import Image as Pillow  # noqa: PLC0415 - only bags with compressed pictures need it
    from PIL import UnidentifiedImageError  # noqa: PLC0415

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of large sizes, which are refused
            with Pillow.open(io.BytesIO(bytes(ros.data)), formats=("JPEG", "PNG")) as picture:
                _check_size(picture.height, picture.width)
                is_deep = picture.mode.startswith(("I", "F"))
                pixels = np.array(picture if is_deep or picture.mode == "L" else picture.convert("RGB"))
    except FieldError:
        raise
    except UnidentifiedImageError as error:
        raise FieldError("format", f"'{ros.format}'", "JPEG or PNG") from error
    except Exception as error:  # a decoder, and bytes of any program
        raise ValueError(f"its picture cannot be decoded: {error}") from error
    if is_deep:
        raise FieldError("format", f"'{ros.format}' of more than 8 bits", "JPEG or PNG of 8 bits")
    return pixels


def _check_size(rows: int, cols: int) -> None:
    for name, size in (("height", rows), ("width", cols)):
        if size < 1:
            raise FieldError(name, size, "1 or more")
    if rows * cols > MAX_PIXELS:
        raise FieldError("width * height", f"{cols} * {rows}", f"{MAX_PIXELS // 10**6} million at most")
