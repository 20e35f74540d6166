"""Connected regions of obstacle: which of them are large and strong enough to count."""

from __future__ import annotations

import cv2
import numpy as np

from graphnav.arrays import Bools, Floats

_NEIGHBOURS = 8


def kept_regions(is_obstacle: Bools, score: Floats, strong_px: float, min_cells: int) -> Bools:
    """Return the cells of the regions that count, (rows, cols).

    A region is connected over sides and corners. It counts if it has at least ``min_cells`` cells and one of them
    scores more than ``strong_px`` (the second threshold of hysteresis [Canny: A computational approach to edge
    detection, 1986]).
    """
    count, labels, statistics, _ = cv2.connectedComponentsWithStats(
        is_obstacle.view(np.uint8), connectivity=_NEIGHBOURS
    )
    is_strong = np.zeros(count, np.bool_)
    is_strong[labels[is_obstacle & (score > strong_px)]] = True
    counts = is_strong & (statistics[:, cv2.CC_STAT_AREA] >= min_cells)
    counts[0] = False
    return np.asarray(counts[labels])
