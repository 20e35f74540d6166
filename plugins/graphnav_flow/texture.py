"""The structure tensor of an image: how much texture it has, in the direction that has less."""

from __future__ import annotations

import cv2
import numpy as np

from graphnav.arrays import Bools, Bytes, Floats

BLOCK_PX = 4


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
