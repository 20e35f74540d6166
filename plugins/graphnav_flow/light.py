"""Whether the light has changed between two pictures."""

from __future__ import annotations

import cv2
import numpy as np

from graphnav.arrays import Floats

LAYER = 2
"""The layer of the pyramid on which pictures are compared."""
_BLOCKS = (4, 3)
"""Columns and rows of the blocks over which the change is averaged: texture that is not aligned cancels out in them."""
_DARK_GRAY = 4.0
"""Added to both pictures: what is nearly black tells no ratio."""


def change_of_light(now: Floats, before: Floats) -> float:
    """Return the change of brightness between two pictures, (rows, cols), a ratio: the root mean square of the blocks'.

    ``before``: aligned with the other one, and the same as it where that is not possible.
    """
    gray = np.float32(_DARK_GRAY)
    change: Floats = cv2.log((now + gray) / (before + gray))
    blocks = cv2.resize(change, _BLOCKS, interpolation=cv2.INTER_AREA)
    return float(np.sqrt(np.vdot(blocks, blocks) / blocks.size))
