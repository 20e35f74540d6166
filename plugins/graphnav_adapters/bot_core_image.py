"""Adapter of libbot images: ``bot_core.image_t``, which most LCM camera drivers publish."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from graphnav import Adapter, FieldError, Image
from graphnav.arrays import Bytes
from graphnav_adapters.lcmtypes.bot_core import image_t
from graphnav_adapters.pixels import Names, check_size, shape_of, without_padding

GRAY, RGB, BGR, MJPEG = (int.from_bytes(code, "little") for code in (b"GREY", b"RGB3", b"BGR3", b"MJPG"))
"""Values of ``pixelformat``: FourCC codes, first character in the lowest byte."""


_CHANNELS = {GRAY: 1, RGB: 3, BGR: 3}
_NAMES = Names("size", "height", "row_stride")


class BotCoreImage(Adapter):
    """``bot_core.image_t`` to `Image` and back.

    Reads 8-bit gray, RGB, BGR and MJPEG (one JPEG per message, gray or colour as stored); rows may be padded
    (``row_stride``, bytes). Writes gray or RGB, uncompressed, without padding; a thinned image is written at its
    thinned size. Metadata are neither read nor written. ``utime`` is the sender's.
    """

    type_name = "bot_core.image_t"
    lcm_class = image_t
    message = Image

    def from_lcm(self, fields: Mapping[str, Any]) -> Image:
        """Return the picture: uint8, (rows, cols) or (rows, cols, 3) red-green-blue.

        Raises
        ------
        ValueError
            Width, height, row_stride and size contradict each other or the JPEG, the image has more than 64 million
            pixels, the JPEG is truncated or damaged, or the pixel format is not supported.
        """
        rows, cols, pixelformat = fields["height"], fields["width"], fields["pixelformat"]
        check_size(rows, cols)
        data: Bytes = np.asarray(fields["data"], np.uint8)
        if pixelformat == MJPEG:
            return Image(pixels=_decompressed(data, rows, cols))
        if pixelformat not in _CHANNELS:
            raise FieldError("pixelformat", _shown(pixelformat), ", ".join(map(_shown, (*_CHANNELS, MJPEG))))
        pixels = without_padding(data, rows, cols * _CHANNELS[pixelformat], fields["row_stride"], _NAMES)
        if pixelformat == GRAY:
            return Image(pixels=pixels)
        colours = pixels.reshape(rows, cols, 3)
        return Image(pixels=colours if pixelformat == RGB else np.ascontiguousarray(colours[:, :, ::-1]))

    def to_lcm(self, message: Image, utime: int) -> Mapping[str, Any]:
        """Return the fields of an uncompressed gray or RGB picture.

        Raises
        ------
        ValueError
            The picture is neither gray nor RGB.
        """
        rows, cols, channels = shape_of(message.pixels)
        return {
            "utime": utime,
            "width": cols,
            "height": rows,
            "row_stride": cols * channels,
            "pixelformat": GRAY if channels == 1 else RGB,
            "data": message.pixels.reshape(-1),
            "metadata": (),
        }


def _decompressed(data: Bytes, rows: int, cols: int) -> Bytes:
    from graphnav_adapters.jpeg import decode_jpeg

    pixels = decode_jpeg(data.tobytes())
    if pixels.shape[:2] != (rows, cols):
        found = f"{pixels.shape[1]}x{pixels.shape[0]}"
        raise FieldError("width x height", f"{cols}x{rows}", f"{found}, which its JPEG has")
    return pixels


def _shown(pixelformat: int) -> str:
    """Return a pixel format with its FourCC code, if it is one."""
    code = (pixelformat & 0xFFFFFFFF).to_bytes(4, "little").decode("latin-1")
    return f"{pixelformat} ({code})" if code.isascii() and code.isprintable() else str(pixelformat)
