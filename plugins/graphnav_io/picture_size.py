"""Limit the size of pictures: a file's header may declare any size, for which a decoder would reserve memory."""

from __future__ import annotations

import io
import warnings

from PIL import Image

MAX_PIXELS = 64_000_000
"""More than any robot camera has."""
MAX_BYTES = 256 * 1024**2
"""Of a picture's file."""


def check_pixels(rows: float, cols: float) -> None:
    """Raise ValueError if a picture has more than `MAX_PIXELS`."""
    if rows * cols > MAX_PIXELS:
        raise ValueError(f"{cols:.0f}x{rows:.0f} pixels are more than {MAX_PIXELS // 10**6} million")


def check_header(data: bytes) -> None:
    """Raise ValueError if the header of a picture's file declares more than `MAX_PIXELS`; others pass."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(io.BytesIO(data)) as header:
                cols, rows = header.size
    except Image.DecompressionBombError as error:
        raise ValueError(f"its header declares more than {MAX_PIXELS // 10**6} million pixels") from error
    except (OSError, ValueError):  # not a kind that Pillow knows: OpenCV decides
        return
    check_pixels(rows, cols)
