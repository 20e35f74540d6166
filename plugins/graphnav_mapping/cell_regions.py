"""Regions of cells, and distances from them."""

from __future__ import annotations

import math

import cv2
import numpy as np

from graphnav.arrays import Bools, Floats


def small_regions(cells: Bools, min_cells: float) -> Bools:
    """Return the ``cells`` (rows, cols) that are in connected regions of fewer than so many."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(cells.view(np.uint8), connectivity=4)
    is_small = stats[:, cv2.CC_STAT_AREA] < min_cells
    is_small[0] = False
    return np.asarray(is_small[labels])


def distance_m(there: Bools, cell_m: float) -> Floats:
    """Return the distance from the middle of every cell to the rim of the nearest one ``there``, or across the grid."""
    farthest = np.float32(cell_m * math.hypot(*there.shape))
    cells = cv2.distanceTransform((~there).view(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    # OpenCV's last bit depends on where memory lies. The square of a distance between cells is an integer.
    apart = np.sqrt(np.rint(np.minimum(cells, np.float32(math.hypot(*there.shape))) ** 2))
    rim_m: Floats = np.clip((apart - np.float32(0.5)) * np.float32(cell_m), np.float32(0.0), farthest)
    return rim_m
