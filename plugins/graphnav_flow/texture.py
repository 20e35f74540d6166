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
    """

    def __init__(self, rows: int, cols: int) -> None:
        self._size = (cols, rows)
        self._blocks = (max(1, cols // BLOCK_PX), max(1, rows // BLOCK_PX))
        # The gradient at the border, which is never written, is that of the mirrored image: 0.
        self._gray, self._gu, self._gv, self._product = np.zeros((4, rows, cols), np.float32)

    def measure(self, gray: Bytes) -> Floats:
        """Return the measure at every pixel of ``gray``, float32 (rows, cols)."""
        fine: Floats = cv2.resize(self._measure_blocks(gray), self._size)
        return fine

    def reaches(self, gray: Bytes, threshold_gray2: float) -> Bools:
        """Return where the measure is at least ``threshold_gray2``, (rows, cols)."""
        coarse = self._measure_blocks(gray)
        if coarse.min() >= threshold_gray2:
            return np.ones(gray.shape, bool)
        enough: Bools = cv2.resize(coarse, self._size) >= threshold_gray2
        return enough

    def _measure_blocks(self, gray: Bytes) -> Floats:
        """Return the measure on the grid of blocks."""
        base, gu, gv = self._gray, self._gu, self._gv
        np.copyto(base, gray)
        np.subtract(base[:, 2:], base[:, :-2], out=gu[:, 1:-1])
        np.subtract(base[2:], base[:-2], out=gv[1:-1])
        means = []
        for one, other in ((gu, gu), (gu, gv), (gv, gv)):
            np.multiply(one, other, out=self._product)
            means.append(cv2.resize(self._product, self._blocks, interpolation=cv2.INTER_AREA))
        uu, uv, vv = cv2.split(cv2.blur(cv2.merge(means), (3, 3)))
        # Both derivatives were twice too large.
        smaller = min_eigenvalue(uu, uv, vv)
        smaller /= 4
        return smaller
