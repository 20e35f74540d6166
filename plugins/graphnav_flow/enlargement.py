"""Carry a displacement field from one pyramid layer to the next, smoothed."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from graphnav.arrays import Floats


class Enlargement:
    """Doubles a field in size and value, and averages it over a box of ``smooth_px`` of the larger layer.

    The average is taken before, where it costs a quarter: over half the box, whose outer pixels count in part.
    """

    def __init__(self, smooth_px: int) -> None:
        width = max(smooth_px / 2, 1)
        inner = 2 * int((width - 1) / 2) + 1
        rest = (width - inner) / 2
        kernel = np.array([rest, *[1] * inner, rest]) / width
        # Applied along rows and columns: the product doubles the values.
        self._kernel = (kernel * np.sqrt(2)).astype(np.float32)

    def enlarge(self, planes: Sequence[Floats], larger: Sequence[Floats]) -> None:
        """Write each of ``planes``, (rows, cols), which it overwrites, to one of ``larger``; pixel i to pixel 2i."""
        for plane, out in zip(planes, larger, strict=True):
            rows, cols = out.shape
            cv2.sepFilter2D(plane, -1, self._kernel, self._kernel, plane)
            cv2.pyrUp(plane, out, (cols, rows))
