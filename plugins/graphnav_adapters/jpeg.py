"""Decode a JPEG from the network; its header is checked before anything is decoded."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from graphnav import FieldError
from graphnav.arrays import Bytes
from graphnav_adapters.pixels import check_size

_START, _END = b"\xff\xd8", b"\xff\xd9"
_SCAN = 0xDA
_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
"""Markers of frame headers, SOF0 to SOF15, without the three with another meaning."""
_BARE = frozenset((0x01, *range(0xD0, 0xD8)))
"""Markers without a segment."""
_MIN_FRAME_BYTES = 8
"""Layout of a frame header's segment: length (2 bytes), bits, rows (2), columns (2), channels."""
_AS_STORED = cv2.IMREAD_ANYCOLOR | cv2.IMREAD_IGNORE_ORIENTATION


class JpegHeader(NamedTuple):
    """The header of a JPEG; its first scan begins at the offset ``scan_at``."""

    rows: int
    cols: int
    channels: int
    scan_at: int


def read_header(data: bytes) -> JpegHeader:
    """Return the header of a JPEG without decoding the image.

    Raises
    ------
    ValueError
        It is not a JPEG, or its header is truncated or damaged.
    """
    if not data.startswith(_START):
        raise ValueError(f"data is not a JPEG: it begins with {data[:4].hex(' ') or 'nothing'}, expected ff d8")
    at, frame = len(_START), None
    while at + 4 <= len(data):
        if data[at] != 0xFF:
            raise ValueError(f"data is a JPEG with a damaged header: {data[at]:02x} at byte {at}, expected ff")
        marker = data[at + 1]
        if marker == 0xFF or marker in _BARE:
            at += 1 if marker == 0xFF else 2
            continue
        if marker == _SCAN and frame is not None:
            rows, cols = int.from_bytes(frame[1:3]), int.from_bytes(frame[3:5])
            return JpegHeader(rows, cols, frame[5], at)
        length = int.from_bytes(data[at + 2 : at + 4])
        if length < (_MIN_FRAME_BYTES if marker in _FRAMES else 2):
            raise ValueError(f"data is a JPEG with a damaged header: a segment of {length} bytes at byte {at}")
        if marker in _FRAMES:
            frame = data[at + 4 : at + 2 + length]
        at += 2 + length
    raise ValueError(f"data is a JPEG that is truncated: {len(data)} bytes end within its header")


def decode_jpeg(data: bytes) -> Bytes:
    """Return a JPEG's pixels: uint8, (rows, cols) or (rows, cols, 3) red-green-blue, as stored.

    Raises
    ------
    ValueError
        It is not a JPEG, is truncated or damaged, has neither 1 nor 3 channels, or is larger than `check_size` allows.
    """
    header = read_header(data)
    check_size(header.rows, header.cols, "the JPEG's ")
    if header.channels not in (1, 3):
        raise FieldError("the JPEG's number of channels", header.channels, "1 (gray) or 3 (colour)")
    if data.find(_END, header.scan_at) < 0:
        raise ValueError(f"data is a JPEG that is truncated: {len(data)} bytes without its end (ff d9)")
    try:
        pixels = cv2.imdecode(np.frombuffer(data, np.uint8), _AS_STORED)
    except cv2.error as error:
        raise ValueError(f"data is a JPEG that cannot be decoded: {error.err}") from error
    if pixels is None:
        raise ValueError("data is a JPEG that cannot be decoded")
    decoded: Bytes = pixels if pixels.ndim == 2 else cv2.cvtColor(pixels, cv2.COLOR_BGR2RGB)
    return decoded


def encode_jpeg(pixels: Bytes) -> Bytes:
    """Return pixels, uint8, (rows, cols) or (rows, cols, 3) red-green-blue, as a JPEG of OpenCV's default quality."""
    ordered = pixels if pixels.ndim == 2 else cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR)
    encoded: Bytes = cv2.imencode(".jpg", ordered)[1].reshape(-1)
    return encoded
