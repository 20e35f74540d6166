"""How much each cell of the flow counts, by how far its vector is likely to be off."""

from __future__ import annotations

import numpy as np

from graphnav import Flow, FlowDeviation
from graphnav.arrays import Floats


def certainty(cells: Flow, deviation: FlowDeviation, enough_px: float) -> Floats:
    """Return the weight of a difference from the ground at each of ``cells``, float32 (rows, cols), above 0 up to 1.

    It is 1 where the deviation is at most ``enough_px``, and its share of the deviation elsewhere: with it, differences
    that are only errors have the same size everywhere.
    """
    there_px = deviation.at(cells.valid.shape, cells.step_px)
    return np.asarray(np.float32(enough_px) / np.maximum(there_px, np.float32(enough_px)), np.float32)
