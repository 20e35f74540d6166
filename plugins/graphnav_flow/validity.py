"""Validity of flow vectors: the common rule of all estimators.

A vector is valid where

- the pixel and its source lie inside the image by a margin: nearer to the border windows extend
  beyond the picture, and new parts of the picture are extrapolated;
- the image has texture there in two directions: the smaller eigenvalue of the windowed mean of the gradient's outer
  product [Shi, Tomasi: Good Features to Track, CVPR 1994] reaches a threshold. Image noise of standard deviation s
  alone gives about s^2 / 2.
"""

from __future__ import annotations

import cv2
import numpy as np

from graphnav.arrays import Bools, Bytes, Floats

MARGIN_PX = 6.0
MARGIN_DOC = "vectors from or at places nearer to the border than this are not valid"
MIN_TEXTURE_GRAY2 = 4.0
MIN_TEXTURE_DOC = "minimum of the smaller eigenvalue of the structure tensor for a vector to be valid"
BLOCK_PX = 4
"""Side of the blocks over which the structure tensor is averaged first."""
_BOTH = 0x0101
"""Two adjacent true values, read as one integer."""


class Validity:
    """Applies the rule to the flow on images of one size."""

    def __init__(self, margin_px: float, min_texture_gray2: float) -> None:
        self._margin_px, self._min_texture_gray2 = margin_px, min_texture_gray2
        self._parts: tuple[Texture, Inside] | None = None

    def mark(self, uv_px: Floats, gray: Bytes | Floats) -> Bytes:
        """Return 1 where a vector on the image ``gray`` is valid by both parts of the rule, uint8 (rows, cols).

        ``gray``: uint8 or float32 (rows, cols).
        """
        if self._parts is None:
            rows, cols = gray.shape
            self._parts = Texture(rows, cols), Inside(rows, cols, self._margin_px)
        texture, inside = self._parts
        valid = inside.mark(uv_px)
        texture.clear_below(self._min_texture_gray2, gray, valid)
        return valid.view(np.uint8)


class Inside:
    """Finds the vectors that stay inside images of one size by a margin; reuses its buffers."""

    def __init__(self, rows: int, cols: int, margin_px: float) -> None:
        x, y = np.arange(cols, dtype=np.float32), np.arange(rows, dtype=np.float32)[:, None]
        self._max_px, self._min_px = np.empty((2, rows, cols, 2), np.float32)
        for channel, (place, size) in enumerate(((x, cols), (y, rows))):
            self._max_px[..., channel] = place - margin_px
            self._min_px[..., channel] = place - (size - 1 - margin_px)
        # No vector reaches inf.
        self._min_px[(self._max_px < 0).any(axis=-1) | (self._min_px > 0).any(axis=-1)] = np.inf
        self._below_max, self._above_min = np.empty((2, rows, cols, 2), bool)
        self._both = self._below_max.view(np.uint16)[..., 0]

    def mark(self, uv_px: Floats) -> Bools:
        """Return where a pixel and its source lie inside, (rows, cols).

        ``uv_px``: float32 (rows, cols, 2), displacement since the last frame of what is now at the pixel.
        """
        np.less_equal(uv_px, self._max_px, self._below_max)
        np.greater_equal(uv_px, self._min_px, self._above_min)
        np.logical_and(self._below_max, self._above_min, self._below_max)
        inside: Bools = self._both == _BOTH
        return inside


def min_eigenvalue(uu: Floats, uv: Floats, vv: Floats) -> Floats:
    """Return the smaller eigenvalue of the symmetric matrices [[uu, uv], [uv, vv]], float32 (rows, cols)."""
    smaller: Floats = (uu + vv - cv2.magnitude(uu - vv, 2 * uv)) / 2
    return smaller


class Texture:
    """Measures the smaller eigenvalue of the structure tensor, (gray / px)^2; reuses its buffers.

    The tensor is averaged over 3x3 blocks of 4x4 pixels, a fifth of the cost of a window around every pixel.
    Images are uint8 or float32 (rows, cols).
    """

    def __init__(self, rows: int, cols: int) -> None:
        self._size = (cols, rows)
        self._blocks = (max(1, cols // BLOCK_PX), max(1, rows // BLOCK_PX))
        self._enough = np.empty((rows, cols), bool)
        self._gray, self._gu, self._gv, self._product = np.zeros((4, rows, cols), np.float32)

    def measure(self, gray: Bytes | Floats) -> Floats:
        """Return the measure at every pixel of ``gray``, float32 (rows, cols)."""
        fine: Floats = cv2.resize(self._measure_blocks(gray), self._size)
        return fine

    def clear_below(self, threshold_gray2: float, gray: Bytes | Floats, mask: Bools) -> None:
        """Clear ``mask``, (rows, cols), where the measure is below ``threshold_gray2``."""
        coarse = self._measure_blocks(gray)
        if coarse.min() < threshold_gray2:
            cv2.resize(coarse, self._size, self._product)
            np.greater_equal(self._product, threshold_gray2, self._enough)
            np.logical_and(mask, self._enough, mask)

    def _measure_blocks(self, gray: Bytes | Floats) -> Floats:
        """Return the measure on the grid of blocks."""
        self._differentiate(gray)
        means = []
        for one, other in ((self._gu, self._gu), (self._gu, self._gv), (self._gv, self._gv)):
            np.multiply(one, other, self._product)
            means.append(cv2.resize(self._product, self._blocks, None, 0, 0, cv2.INTER_AREA))
        smaller = min_eigenvalue(*(cv2.blur(mean, (3, 3), mean) for mean in means))
        smaller /= 4
        return smaller

    def _differentiate(self, gray: Bytes | Floats) -> None:
        """Write twice the gradient of ``gray``; at the border that of the mirrored image, which is 0."""
        gu, gv = self._gu, self._gv
        if gray.dtype != np.float32:
            self._gray[...] = gray
            gray = self._gray
        # One line of all pixels is faster than rows that are not adjacent.
        line = gray.ravel()
        np.subtract(line[2:], line[:-2], gu.ravel()[1:-1])
        gu[:, 0] = gu[:, -1] = 0
        np.subtract(gray[2:], gray[:-2], gv[1:-1])
