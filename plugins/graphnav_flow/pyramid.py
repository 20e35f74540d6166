"""Image pyramids for Lucas-Kanade."""

from __future__ import annotations

import cv2
import numpy as np

from graphnav.arrays import Bytes, Floats

MIN_SIDE_PX = 8
"""A layer is not halved if its shorter side would fall below this: no window fits."""


_HALFWAY = np.array([[3, -25, 150, 150, -25, 3]], np.float32) / np.float32(256)
"""Interpolates half way between two pixels: exact for polynomials up to the fifth degree."""


class Pyramid:
    """One frame at several sizes; reuses its buffers.

    ``layers``: float32 (rows, cols), the base first, each half as large as the one before; pixel i of a layer lies on
    pixel 2i of the one before.
    """

    def __init__(self, rows: int, cols: int, layers: int) -> None:
        self.layers: list[Floats] = [np.empty((rows, cols), np.float32)]
        while len(self.layers) <= layers and min(rows, cols) >= 2 * MIN_SIDE_PX:
            rows, cols = (rows + 1) // 2, (cols + 1) // 2
            self.layers.append(np.empty((rows, cols), np.float32))

    def fill(self, gray: Bytes) -> None:
        """Write ``gray`` and its smaller copies to the layers."""
        np.copyto(self.layers[0], gray)
        for larger, smaller in zip(self.layers, self.layers[1:], strict=False):
            cv2.pyrDown(larger, dst=smaller)


class Doubling:
    """Doubles images of one size; reuses its buffers.

    Sampling the doubled image bilinearly is nearly as exact as sampling the image with a long kernel, at a fifth of
    the time.
    """

    def __init__(self, rows: int, cols: int) -> None:
        self._right = np.empty((rows, cols), np.float32)
        doubled = np.empty((2 * rows, 2 * cols), np.float32)
        self._lines, self._between = doubled[::2], doubled[1::2]
        self._pairs = doubled.reshape(rows, 2, cols, 2)[:, 0]
        self._doubled = doubled[:-1, :-1]

    def double(self, image: Floats) -> Floats:
        """Return ``image`` with one value between any two, float32 (2 rows - 1, 2 cols - 1), valid until the next call.

        Pixel i of the image is its pixel 2i.
        """
        before = _HALFWAY.size // 2 - 1
        cv2.filter2D(image, -1, _HALFWAY, dst=self._right, anchor=(before, 0))
        cv2.merge([image, self._right], dst=self._pairs)
        cv2.filter2D(self._lines, -1, _HALFWAY.T, dst=self._between, anchor=(0, before))
        return self._doubled
