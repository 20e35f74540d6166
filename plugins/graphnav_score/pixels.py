"""True pixels under the cells of a grid: the way in which grids of cells are compared with the truth."""

from __future__ import annotations

import numpy as np

from graphnav import Truth, block_sum
from graphnav.arrays import Longs


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


def count_pixels(truth: Truth, shape: tuple[int, ...], step_px: int) -> tuple[Longs, Longs]:
    """Return how many true pixels of each cell are obstacle and how many are ground, both ``shape``.

    The same as repeating each cell over its pixels: cells cut off at the rim count their remaining pixels. Pixels
    above the horizon are neither.

    Raises
    ------
    ValueError
        The grid does not fit the truth.
    """
    factor = cell_factor(truth, shape, step_px)
    is_obstacle = truth.obstacle != 0
    is_ground = ~is_obstacle & np.isfinite(truth.depth_m)
    return block_sum(is_obstacle.astype(np.int64), factor), block_sum(is_ground.astype(np.int64), factor)
