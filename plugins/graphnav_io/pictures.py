"""Read pictures from files."""

from __future__ import annotations

import glob
import re
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from graphnav import ParamError, read_regular
from graphnav.arrays import Bytes
from graphnav_io.picture_size import MAX_BYTES, check_header
from graphnav_io.quiet import quiet

SUFFIXES = frozenset((".jpg", ".jpeg", ".png", ".bmp", ".tif", ".tiff", ".webp", ".pgm", ".ppm"))
_PNG_SIGNATURE_BYTES, _PNG_CHUNK_BYTES = 8, 12
"""Of a file's begin, and of a chunk beside its content: length, type and checksum."""


def is_pictures(path: Path) -> bool:
    """Return whether ``path`` is a folder or a pattern, not a single file."""
    return path.is_dir() or (glob.has_magic(str(path)) and not path.exists())


def find_pictures(path: Path) -> list[Path]:
    """Return the pictures in a folder (by suffix), or whatever files a pattern matches, in natural order.

    Raises
    ------
    ParamError
        The folder does not exist, or contains no picture.
    """
    if path.is_dir():
        try:
            found = [file for file in path.iterdir() if file.suffix.lower() in SUFFIXES]
        except OSError as error:
            raise ParamError("path", f"'{path}' cannot be read: {error.strerror}") from error
        if not found:
            raise ParamError("path", f"there is no picture in '{path}'", f"use files that end in {_suffixes()}")
    elif path.is_file():
        found = [path]
    elif glob.has_magic(str(path)):
        found = [Path(file) for file in glob.glob(str(path), recursive=True) if Path(file).is_file()]
        if not found:
            raise ParamError("path", f"no file matches '{path}'", "check the pattern")
    else:
        raise ParamError(
            "path", f"there is no folder '{path}'", "give a folder of pictures or a pattern like run/*.jpg"
        )
    return sorted(found, key=_natural)


def read_picture(file: Path) -> Bytes:
    """Return a picture: uint8, (rows, cols) or (rows, cols, 3) red-green-blue.

    Raises
    ------
    ValueError
        The file cannot be read or decoded, is truncated, or has too many pixels.
    """
    try:
        data = read_regular(file, MAX_BYTES)
    except OSError as error:
        raise ValueError(f"'{file}' cannot be read: {error.strerror}") from error
    if not data:
        raise ValueError(f"'{file}' is empty")
    if not _is_complete(data):
        raise ValueError(f"'{file}' is truncated or damaged")
    try:
        check_header(data)
    except ValueError as error:
        raise ValueError(f"'{file}' is too large a picture: {error}") from error
    pixels = _decoded(data)
    if pixels is None:
        raise ValueError(f"'{file}' is not a picture that OpenCV can read")
    return pixels if pixels.ndim == 2 else cv2.cvtColor(pixels, cv2.COLOR_BGR2RGB)


def _decoded(data: bytes) -> Bytes | None:
    """Return the pixels in the bytes of a file as OpenCV orders them, None if it cannot decode them."""
    try:
        with quiet():
            pixels: Bytes | None = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_ANYCOLOR)
    except cv2.error:
        return None
    return pixels


def check_pictures(path: Path) -> Bytes:
    """Return the first picture, once it is known that there is one and that it can be decoded.

    Raises
    ------
    ParamError
        There is no picture, or the first one cannot be decoded.
    """
    try:
        return read_picture(find_pictures(path)[0])
    except ValueError as error:
        raise ParamError("path", str(error)) from error


class PictureFrames:
    """Frames from picture files; they have no rate of their own."""

    rate_hz = 0.0

    def __init__(self, files: Sequence[Path]) -> None:
        self._left = list(reversed(files))

    @property
    def at_end(self) -> bool:
        """Whether all files were read."""
        return not self._left

    def read(self) -> Bytes | None:
        """Return the next file's picture, None after the last."""
        return read_picture(self._left.pop()) if self._left else None

    def close(self) -> None:
        """Do nothing: no file stays open."""


def _natural(file: Path) -> list[tuple[int, str]]:
    """Order frame_2 before frame_10."""
    parts = re.split(r"(\d+)", str(file))
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in parts] + [(-1, str(file))]


def _is_complete(data: bytes) -> bool:
    """Return whether a JPEG or PNG is complete; decoders fill missing parts with gray and only warn."""
    if data.startswith(b"\xff\xd8"):
        return data.rfind(b"\xff\xd9") > data.rfind(b"\xff\xda")
    return not data.startswith(b"\x89PNG") or _chunks_end(data)


def _chunks_end(data: bytes) -> bool:
    """Return whether the chunks of a PNG lead to its end, each within the file: decoders reserve what one declares."""
    at = _PNG_SIGNATURE_BYTES
    while at + _PNG_CHUNK_BYTES <= len(data):
        if data[at + 4 : at + 8] == b"IEND":
            return True
        at += _PNG_CHUNK_BYTES + int.from_bytes(data[at : at + 4], "big")
    return False


def _suffixes() -> str:
    *first, last = (suffix[1:] for suffix in sorted(SUFFIXES))
    return ", ".join(first) + " or " + last
