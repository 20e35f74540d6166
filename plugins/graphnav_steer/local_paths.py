"""Cheapest paths on a local map, from the robot to every cell that it may reach."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from graphnav.arrays import Bools, Doubles, Indices

_NONE = -9999
"""The name in scipy for the predecessor of a cell that is not reached."""


class Paths(NamedTuple):
    """Cheapest paths over the passable ones of a grid's cells, which are numbered in row-major order.

    ``cost_m``: (rows, cols), infinite where no path leads; ``number``: (rows, cols), of passable cells; ``cells``:
    (n, 2), their rows and columns; ``before``: (n,), the number of the cell before each.
    """

    cost_m: Doubles
    number: Indices
    cells: Indices
    before: Indices

    def to(self, row: int, col: int) -> Indices:
        """Return the rows and columns of the path's cells from the robot to this cell, (n, 2)."""
        numbers = [int(self.number[row, col])]
        while (number := int(self.before[numbers[-1]])) != _NONE:
            numbers.append(number)
        return self.cells[numbers[::-1]]


def cheapest_paths(start: tuple[int, int], price: Doubles, cell_m: float) -> Paths:
    """Return the cheapest paths from a cell, over cells of finite ``price`` per metre (rows, cols)."""
    passable = np.isfinite(price)
    passable[start] = True
    n, prices = int(passable.sum()), price[passable]
    number = np.zeros((price.shape[0], price.shape[1] + 1), np.intp)
    number[:, :-1][passable] = np.arange(n)
    places, other_places, length = _edges(passable)
    here, there = number.reshape(-1)[places], number.reshape(-1)[other_places]
    costs = (prices[here] + prices[there]) * (length * cell_m / 2)
    graph = csr_array((costs, (here, there)), shape=(n, n))
    cost_m = np.full(price.shape, math.inf)
    cost_m[passable], before = dijkstra(graph, indices=number[start], return_predecessors=True, directed=False)
    return Paths(cost_m, number[:, :-1], np.argwhere(passable), before)


def _edges(passable: Bools) -> tuple[Indices, Indices, Doubles]:
    """Return the places of both cells of each edge between neighbours, each edge once, and its length in cells.

    Places are those in the grid, flat, with a column more, through which no edge leads.
    """
    width = passable.shape[1] + 1
    flat = np.pad(passable, ((0, 0), (0, 1))).reshape(-1)
    steps = {1: 1.0, width: 1.0, width + 1: math.sqrt(2.0), width - 1: math.sqrt(2.0)}
    places = [np.flatnonzero(flat[:-step] & flat[step:]) for step in steps]
    lengths = [np.full(len(one), length) for one, length in zip(places, steps.values(), strict=True)]
    others = [one + step for one, step in zip(places, steps, strict=True)]
    return np.concatenate(places), np.concatenate(others), np.concatenate(lengths)


def beside(cells: Bools) -> Bools:
    """Return which cells have one of ``cells`` (rows, cols) above, below, to the left or right."""
    near = np.zeros_like(cells)
    near[1:] |= cells[:-1]
    near[:-1] |= cells[1:]
    near[:, 1:] |= cells[:, :-1]
    near[:, :-1] |= cells[:, 1:]
    return near
