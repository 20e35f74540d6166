"""Weights of the cells of the dominant map."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from graphnav.arrays import Doubles


@lru_cache(maxsize=16)
def cell_weights(rows: int, cols: int, bell_ratio: float | None, near_weight: float) -> Doubles:
    """Return the weight of every cell, (rows, cols), at most 1.

    ``bell_ratio``: standard deviation of a bell across the picture, in picture widths; None for none.
    ``near_weight``: weight of the lowest row, from where it grows linearly to 1 at the highest.
    """
    across = np.ones(cols)
    if bell_ratio is not None:
        across = np.exp(-0.5 * ((np.arange(cols) - (cols - 1) / 2) / (bell_ratio * cols)) ** 2)
    weights: Doubles = np.linspace(1.0, near_weight, rows)[:, None] * across
    weights.setflags(write=False)
    return weights
