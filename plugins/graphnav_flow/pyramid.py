"""Image pyramids for Lucas-Kanade."""

from __future__ import annotations

import cv2
import numpy as np

from graphnav.arrays import Bytes, Floats
from graphnav_flow.normalization import Normalization

MIN_SIDE_PX = 8
"""A layer is not halved if its shorter side would fall below this: no window fits."""


_POLE = -3 + 8**0.5
_SHARPEN = (_POLE ** np.abs(np.arange(-3, 4))).astype(np.float32)[None]
_SHARPEN /= _SHARPEN.sum()
"""Inverse of (1, 6, 1) / 8, with which pyrUp averages the pixels of an image: after it they keep their values."""


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
        self._normalized: Pyramid | None = None
        self._is_normalized = False

    def fill(self, gray: Bytes) -> None:
        """Write ``gray`` and its smaller copies to the layers."""
        self._is_normalized = False
        self.layers[0][...] = gray
        for larger, smaller in zip(self.layers, self.layers[1:], strict=False):
            cv2.pyrDown(larger, smaller)

    def normalized(self, normalization: Normalization) -> Pyramid:
        """Return this frame with its layers normalized, which is done once, although two flows need it."""
        if self._normalized is None:
            rows, cols = self.layers[0].shape
            self._normalized = Pyramid(rows, cols, len(self.layers) - 1)
        if not self._is_normalized:
            for own, layer in zip(self._normalized.layers, self.layers, strict=True):
                own[...] = layer
            normalization.normalize(self._normalized.layers)
            self._is_normalized = True
        return self._normalized


class Doubling:
    """Doubles images of one size; reuses its buffers.

    Sampling the doubled image bilinearly is nearly as exact as sampling the image with a long kernel, at a fifth of
    the time.
    """

    def __init__(self, rows: int, cols: int) -> None:
        self._sharpened = np.empty((rows, cols), np.float32)
        self._doubled = np.empty((2 * rows, 2 * cols), np.float32)

    def double(self, image: Floats) -> Floats:
        """Return ``image`` with one value between any two, float32 (2 rows - 1, 2 cols - 1), valid until the next call.

        Pixel i of the image is its pixel 2i.
        """
        cv2.sepFilter2D(image, -1, _SHARPEN, _SHARPEN, self._sharpened)
        cv2.pyrUp(self._sharpened, self._doubled)
        return self._doubled[:-1, :-1]
