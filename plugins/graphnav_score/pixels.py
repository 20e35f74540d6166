"""True pixels under the cells of a grid: the way in which grids of cells are compared with the truth."""

from __future__ import annotations

import cv2
import numpy as np

from graphnav import Truth, block_mean
from graphnav.arrays import Bools, Floats


def cell_factor(truth: Truth, shape: tuple[int, ...], step_px: int) -> int:
    """Return how many of the truth's rows make one row of a grid of this shape and step.

    Raises
    ------
    ValueError
        The grid is of another image, or its cells are not a multiple of the truth's.
    """
    factor, rest = divmod(step_px, truth.step_px)
    rows, cols = truth.obstacle.shape
    if rest or not factor or tuple(shape) != (-(-rows // factor), -(-cols // factor)):
        raise ValueError(
            f"a grid of {shape[1]}x{shape[0]} cells of {step_px} px cannot be compared with a truth of "
            f"{cols}x{rows} cells of {truth.step_px} px"
        )
    return factor


def count_pixels(truth: Truth, shape: tuple[int, ...], step_px: int) -> Floats:
    """Return how many true pixels of each cell are ground and how many are obstacle, (2, rows, cols).

    The same as repeating each cell over its pixels: cells cut off at the rim count their remaining pixels. Pixels
    above the horizon are neither.

    Raises
    ------
    ValueError
        The grid does not fit the truth.
    """
    factor = cell_factor(truth, shape, step_px)
    is_obstacle = truth.obstacle != 0
    counts = np.empty((2, *shape), np.float32)
    _count(is_obstacle, factor, counts[1])
    shows_sky = not cv2.norm(truth.depth_m, cv2.NORM_INF) < np.inf
    if shows_sky or any(size % factor for size in is_obstacle.shape):
        _count(~is_obstacle & np.isfinite(truth.depth_m), factor, counts[0])
    else:
        np.subtract(np.float32(factor * factor), counts[1], out=counts[0])
    return counts


def _count(pixels: Bools, factor: int, counts: Floats) -> None:
    """Set ``counts`` to how many ``pixels`` are true in each block of ``factor`` rows and columns."""
    np.multiply(block_mean(pixels.astype(np.float32), factor), np.float32(factor * factor), out=counts)
    if factor & (factor - 1):
        np.rint(counts, out=counts)
