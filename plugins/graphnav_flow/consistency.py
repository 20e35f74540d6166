"""The forward-backward check: flow and the flow of the reversed pair must cancel."""

from __future__ import annotations

import cv2
import numpy as np

from graphnav.arrays import Floats

_OUTSIDE_PX = 1e9
"""Stands for the flow outside the picture: not inf, whose product with a weight of 0 is NaN."""


class Consistency:
    """Measures by how much two flows of a pair of one size disagree; reuses its buffers."""

    def __init__(self, rows: int, cols: int) -> None:
        down, right = np.mgrid[:rows, :cols].astype(np.float32)
        self._places = np.dstack([right, down])
        self._source, self._met = np.empty((2, rows, cols, 2), np.float32)

    def disagreement_px(self, forward: Floats, backward: Floats) -> Floats:
        """Return the length of u(x) + w(x - u(x)), float32 (rows, cols); huge where x - u(x) lies outside the picture.

        ``forward``: u, displacement since the last frame of what is now at x. ``backward``: w, the same of the reversed
        pair, on the pixels of the last frame. Both float32 (rows, cols, 2).
        """
        np.subtract(self._places, forward, self._source)
        cv2.remap(backward, self._source, None, cv2.INTER_LINEAR, self._met, cv2.BORDER_CONSTANT, (_OUTSIDE_PX, 0))
        np.add(self._met, forward, self._met)
        length: Floats = cv2.magnitude(self._met[..., 0], self._met[..., 1])
        return length
