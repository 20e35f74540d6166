"""Cheapest paths on a local map, from the robot to every cell that it may reach."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from graphnav.arrays import Bools, Doubles, Indices

_NONE = -9999
"""The name in scipy for the predecessor of a cell that is not reached."""


class Paths(NamedTuple):
    """``cost_m``: (rows, cols), infinite where no path leads; ``before``: (rows * cols,), the cell before each."""

    cost_m: Doubles
    before: Indices

    def to(self, row: int, col: int) -> Indices:
        """Return the rows and columns of the path's cells from the robot to this cell, (n, 2)."""
        cols = self.cost_m.shape[1]
        cells = [row * cols + col]
        while (cell := int(self.before[cells[-1]])) != _NONE:
            cells.append(cell)
        return np.array([divmod(cell, cols) for cell in reversed(cells)])


def cheapest_paths(start: tuple[int, int], price: Doubles, cell_m: float) -> Paths:
    """Return the cheapest paths from a cell, over cells of finite ``price`` per metre (rows, cols)."""
    rows, cols = price.shape
    here, there, length = _edges(rows, cols)
    prices = price.reshape(-1)
    passable = np.isfinite(prices)
    inside = np.flatnonzero(passable[here] & passable[there])
    here, there, length = here[inside], there[inside], length[inside]
    costs = (prices[here] + prices[there]) * (length * cell_m / 2)
    graph = csr_array((costs, (here, there)), shape=(rows * cols, rows * cols))
    cost_m, before = dijkstra(graph, indices=start[0] * cols + start[1], return_predecessors=True, directed=False)
    return Paths(cost_m.reshape(rows, cols), before)


@lru_cache(maxsize=4)
def _edges(rows: int, cols: int) -> tuple[Indices, Indices, Doubles]:
    """Return the two cells of each edge between neighbours of a grid, each edge once, and its length in cells."""
    cells = np.arange(rows * cols).reshape(rows, cols)
    pairs = [
        (cells[:, :-1], cells[:, 1:], 1.0),
        (cells[:-1], cells[1:], 1.0),
        (cells[:-1, :-1], cells[1:, 1:], math.sqrt(2.0)),
        (cells[:-1, 1:], cells[1:, :-1], math.sqrt(2.0)),
    ]
    here = np.concatenate([one.ravel() for one, _, _ in pairs])
    there = np.concatenate([other.ravel() for _, other, _ in pairs])
    length = np.concatenate([np.full(one.size, size) for one, _, size in pairs])
    return here, there, length


def beside(cells: Bools) -> Bools:
    """Return which cells have one of ``cells`` (rows, cols) above, below, to the left or right."""
    near = np.zeros_like(cells)
    near[1:] |= cells[:-1]
    near[:-1] |= cells[1:]
    near[:, 1:] |= cells[:, :-1]
    near[:, :-1] |= cells[:, 1:]
    return near
