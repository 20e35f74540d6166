"""Whether the light has changed between two pictures."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from graphnav.arrays import Floats

LAYER = 2
"""The layer of the pyramid on which pictures are compared."""
_BLOCKS = (4, 3)
"""Columns and rows of the blocks over which the change is averaged: texture that is not aligned cancels out in them."""
_DARK_GRAY = 4.0
"""Added to both pictures: what is nearly black tells no ratio."""


class Light:
    """Compares two pictures of one size, once they are aligned; reuses its buffers."""

    def __init__(self, rows: int, cols: int) -> None:
        down, right = np.mgrid[:rows, :cols].astype(np.float32)
        self._places = np.dstack([right, down])
        self._source = np.empty_like(self._places)

    def change(self, now: Floats, last: Floats, field: Sequence[Floats]) -> float:
        """Return the change of brightness, a ratio: the root mean square of that of the blocks.

        ``field``: the displacement since the last picture in both directions, each (rows, cols), as of the pictures.
        """
        for k, plane in enumerate(field):
            np.subtract(self._places[..., k], plane, self._source[..., k])
        rows, cols = now.shape
        x, y = self._source[..., 0], self._source[..., 1]
        is_inside = (x >= 0) & (x <= cols - 1) & (y >= 0) & (y <= rows - 1)
        before = cv2.remap(last, self._source, None, cv2.INTER_LINEAR, None, cv2.BORDER_REPLICATE)
        gray = np.float32(_DARK_GRAY)
        change = np.where(is_inside, np.log((now + gray) / (before + gray)), np.float32(0.0))
        blocks = cv2.resize(change, _BLOCKS, interpolation=cv2.INTER_AREA)
        return float(np.sqrt(np.vdot(blocks, blocks) / blocks.size))
