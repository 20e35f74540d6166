"""Local normalization: gray without the local brightness, at one local contrast."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from graphnav.arrays import Floats

CONTRAST_GRAY = 40.0
"""Local standard deviation of the result: that of a well-textured floor, so that units of gray keep their meaning."""
_FLOOR_GRAY = 0.5
"""Added to both contrasts, as a root of squares, before they divide: the rounding of gray levels, and a little more."""
_MIN_SIGMA_PX = 2.0
_RESAMPLING_PX2 = 2.0
"""Variance of the binomial filters of pyrDown and pyrUp together, in pixels of the larger image."""

_BORDER = cv2.BORDER_REFLECT
"""Leaves a third of the error at the picture's border that OpenCV's default, which counts the last pixel once, adds."""


class Normalization:
    """Normalizes images of the sizes of a pyramid's layers; reuses its buffers.

    With means under a Gaussian window::

        d = I - mean(I)        I' = 40 d / sqrt(mean(d^2) + c^2)

    c is the contrast of the entire picture, the root mean square of d on the base. I' does not change with the
    brightness of a light or an exposure, and little with a vignette that varies slowly in the picture. With c, a region
    of low contrast stays one, and its noise noise; and so does a layer: a floor that repeats is nearly blank on the
    layers that do not resolve it, where what is left moves in any direction. Each layer has its own mean, with a window
    of ``sigma_px`` of its own pixels: that of the base would remove what the coarse layers consist of, and large
    displacements with it.
    Windows are applied at half the resolution, which takes a fifth of the time.

    Parameters
    ----------
    shapes
        (rows, cols) of each layer.
    sigma_px
        Standard deviation of the window; less than 2 counts as 2.
    """

    def __init__(self, shapes: Sequence[tuple[int, int]], sigma_px: float) -> None:
        variance = (max(sigma_px, _MIN_SIGMA_PX) ** 2 - _RESAMPLING_PX2) / 4
        self._kernel = cv2.getGaussianKernel(2 * round(3 * variance**0.5) + 1, variance**0.5, cv2.CV_32F)
        self._buffers = [
            (np.empty((rows, cols), np.float32), np.empty(((rows + 1) // 2, (cols + 1) // 2), np.float32))
            for rows, cols in shapes
        ]

    def normalize(self, layers: Sequence[Floats]) -> None:
        """Overwrite each of ``layers``, float32 (rows, cols)."""
        floor_gray2 = 0.0
        for layer, (large, small) in zip(layers, self._buffers, strict=True):
            size = layer.shape[::-1]
            self._window(layer, small)
            cv2.pyrUp(small, large, size)
            np.subtract(layer, large, layer)
            np.multiply(layer, layer, large)
            self._window(large, small)
            floor_gray2 = floor_gray2 or float(small.mean()) + _FLOOR_GRAY**2
            np.add(small, np.float32(floor_gray2), small)
            np.sqrt(small, small)
            np.divide(CONTRAST_GRAY, small, small)
            cv2.pyrUp(small, large, size)
            np.multiply(layer, large, layer)

    def _window(self, image: Floats, mean: Floats) -> None:
        """Write the windowed mean of ``image`` at half its resolution."""
        cv2.pyrDown(image, mean, None, _BORDER)
        cv2.sepFilter2D(mean, -1, self._kernel, self._kernel, mean, (-1, -1), 0.0, _BORDER)
