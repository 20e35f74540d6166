"""The obstacle potential and its gradient: a Gaussian over a grid as products of small matrices."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np

from graphnav.arrays import Doubles

Border = Literal["zero", "nearest"]

OBSTACLE_LEVEL = 255.0
"""Weight of an obstacle in the potential [OI, eq. 4]."""
REACH = 5.0
"""Truncation of the Gaussian in standard deviations; the loss is below one millionth."""


class Field(NamedTuple):
    """``potential`` (rows, cols) and its ``gradient`` (rows, cols, 2), right and down, per cell."""

    potential: Doubles
    gradient: Doubles


def obstacle_field(weighted: Doubles, sigma_cells: float, border: Border) -> Field:
    """Return G_sigma * (255 d) and its gradient [OI, eq. 4 to 6].

    ``weighted``: (rows, cols), d, or d times a weight. ``border``: the assumption beyond the grid, "zero" (no
    obstacle, as in the integral) or "nearest" (the outermost cell is repeated). The Gaussian is normalised; the
    gradient is the convolution with its derivative, so that no differences are taken at the border. Matrices are
    cached.
    """
    rows, cols = weighted.shape
    smooth_y, slope_y = _matrices(rows, sigma_cells, border)
    along_x = weighted @ _matrices_x(cols, sigma_cells, border)
    potential_and_right = smooth_y @ along_x
    gradient = np.empty((rows, cols, 2))
    gradient[..., 0] = potential_and_right[:, cols:]
    gradient[..., 1] = slope_y @ along_x[:, :cols]
    return Field(potential_and_right[:, :cols], gradient)


@lru_cache(maxsize=16)
def _matrices_x(cells: int, sigma_cells: float, border: Border) -> Doubles:
    """Return the matrix that smooths rows, beside that which differentiates them, (cells, 2 cells), times 255."""
    matrix: Doubles = OBSTACLE_LEVEL * np.concatenate(_matrices(cells, sigma_cells, border)).T
    matrix = np.ascontiguousarray(matrix)
    matrix.setflags(write=False)
    return matrix


@lru_cache(maxsize=16)
def _matrices(cells: int, sigma_cells: float, border: Border) -> tuple[Doubles, Doubles]:
    """Return the matrices that smooth ``cells`` values and differentiate the result, both (cells, cells)."""
    reach = math.ceil(REACH * sigma_cells)
    distance = np.arange(-reach - cells, reach + cells + 1, dtype=np.float64)
    kernel = np.exp(-0.5 * (distance / sigma_cells) ** 2)
    kernel /= kernel.sum()
    slope = -distance / sigma_cells**2 * kernel
    return _toeplitz(kernel, cells, border), _toeplitz(slope, cells, border)


def _toeplitz(kernel: Doubles, cells: int, border: Border) -> Doubles:
    """Return the matrix whose row i holds ``kernel`` centred on i; with "nearest" its ends are added to the edges."""
    middle = len(kernel) // 2
    inside = np.arange(cells)
    matrix: Doubles = kernel[middle + inside[:, None] - inside[None, :]]
    if border == "nearest":
        tail = np.cumsum(kernel)
        matrix[:, 0] += kernel.sum() - tail[middle + inside]
        matrix[:, -1] += tail[middle + inside - cells]
    matrix.setflags(write=False)
    return matrix
