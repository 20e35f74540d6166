"""Convert frames to the size and colours of the graph."""

from __future__ import annotations

import cv2

from graphnav import ParamError
from graphnav.arrays import Bytes

SIZE_DOC = "columns and rows to resize to; null keeps the size"
SCALE_DOC = "dimensionless: factor to resize by if no size is given"
GRAY_DOC = "convert colours to gray: a third of the bytes"


class Shape:
    """The size and colours of all frames of a source; the first one fixes the size."""

    def __init__(self, size: tuple[int, int] | None, scale: float, *, gray: bool) -> None:
        self._size, self._scale, self._gray = size, scale, gray
        self._first: tuple[int, ...] | None = None

    def apply(self, pixels: Bytes) -> Bytes:
        """Return ``pixels`` converted to this shape.

        Raises
        ------
        ValueError
            The size differs from that of the first frame.
        """
        if self._gray and pixels.ndim == 3:
            pixels = cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY)
        pixels = self._resized(pixels)
        if self._first is None:
            self._first = pixels.shape
        elif pixels.shape[:2] != self._first[:2]:
            (rows, cols), (first_rows, first_cols) = pixels.shape[:2], self._first[:2]
            raise ValueError(f"a frame is {cols}x{rows}, but the first was {first_cols}x{first_rows}: set 'size'")
        return pixels

    def _resized(self, pixels: Bytes) -> Bytes:
        rows, cols = pixels.shape[:2]
        size = self._size or (max(1, round(cols * self._scale)), max(1, round(rows * self._scale)))
        if size == (cols, rows):
            return pixels
        shrinks = size[0] * size[1] < rows * cols
        resized: Bytes = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR)
        return resized


def check_shape(size: tuple[int, int] | None, scale: float) -> None:
    """Refuse a size in combination with a scale.

    Raises
    ------
    ParamError
        Both are given.
    """
    if size is not None and scale != 1.0:
        raise ParamError("scale", f"'scale' is {scale:g}, but 'size' is given too", "remove one of them")
