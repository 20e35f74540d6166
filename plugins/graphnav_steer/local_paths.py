"""Cheapest paths on a local map, from the robot to every cell that it may reach."""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable
from typing import NamedTuple

import cv2
import numpy as np

from graphnav import LocalMap
from graphnav.arrays import Bools, Doubles, Indices, Ints

Window = tuple[slice, slice]
"""The rows and the columns of a part of a grid."""
_NONE = -9999
"""The name in scipy for the predecessor of a cell that is not reached."""
_EXACT_M = 1e-6
"""Costs are sums that are as exact as this."""
_SPARE_M = 0.2
_BEND = math.sqrt(2.0) - 1.0
"""Cells by which a step to the side makes a longer way forward longer."""
_CROSS = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
_LENGTHS = np.array([1.0, math.sqrt(2.0), 1.0, math.sqrt(2.0), math.sqrt(2.0), 1.0, math.sqrt(2.0), 1.0])
"""Lengths in cells of the steps from a cell: to the right, to the row below, to the row above, to the left."""


class Floor(NamedTuple):
    """The cells of a grid that can be ``reached`` (rows, cols), and the window that holds them.

    ``price``: a function that returns the cost of a metre, 1 at least, on these cells of a window, (n,), in row-major
    order.
    """

    reached: Bools
    window: Window
    price: Callable[[Window], Doubles]
    cell_m: float


class Paths(NamedTuple):
    """Cheapest paths over the passable ones of a grid's cells, which are numbered in row-major order.

    ``cost_m``: (rows, cols), infinite where no path leads; ``number``: (rows, cols), of passable cells; ``cells``:
    (n,), their places in the grid, flat; ``before``: (n,), the number of the cell before each.
    """

    cost_m: Doubles
    number: Ints
    cells: Indices
    before: Ints

    def to(self, row: int, col: int) -> Indices:
        """Return the rows and columns of the path's cells from the robot to this cell, (n, 2)."""
        numbers = [int(self.number[row, col])]
        while (number := int(self.before[numbers[-1]])) != _NONE:
            numbers.append(number)
        return np.column_stack(np.divmod(self.cells[numbers[::-1]], self.cost_m.shape[1]))


def load_search() -> None:
    """Load the library of the search, which takes long: not in a step, nor where stages are only listed."""
    importlib.import_module("scipy.sparse.csgraph")


def cheapest_paths(
    start: tuple[int, int], passable: Bools, price: Doubles, cell_m: float, limit_m: float = math.inf
) -> Paths:
    """Return the cheapest paths that cost at most ``limit_m``, from one of the cells that are ``passable``.

    ``passable``: (rows, cols); ``price``: (n,), cost of a metre on each of these cells, in row-major order.
    """
    from scipy.sparse import csr_array  # noqa: PLC0415 - see `load_search`
    from scipy.sparse.csgraph import dijkstra  # noqa: PLC0415

    cells, n = np.flatnonzero(passable), len(price)
    # Around the grid and where it is not passable is one cell more, number n, where a step costs infinitely much.
    number = np.full((passable.shape[0] + 2, passable.shape[1] + 1), n, np.int32)
    width, flat = number.shape[1], number.reshape(-1)
    places = cells + (cells // (width - 1) + width)
    flat[places] = np.arange(n, dtype=np.int32)
    there = flat.take(places[:, None] + [1, width - 1, width, width + 1, -width - 1, -width, 1 - width, -1])
    costs = np.append(price, math.inf).take(there)
    costs += price[:, None]
    costs *= _LENGTHS * cell_m / 2
    ends = np.arange(0, 8 * n + 16, 8, dtype=np.int32)
    ends[-1] = 8 * n
    graph = csr_array((costs.reshape(-1), there.reshape(-1), ends), shape=(n + 1, n + 1))
    number = number[1:-1, :-1]
    found_m, before = dijkstra(graph, indices=number[start], return_predecessors=True, limit=limit_m)
    cost_m = np.full(passable.shape, math.inf)
    cost_m.reshape(-1)[cells] = found_m[:-1]
    return Paths(cost_m, number, cells, before)


class NearSearch:
    """Finds the end that is cheapest to reach, and searches no farther for it than it must.

    A metre costs 1 at least. So an end that a search up to a limit has not reached costs more than the limit, and more
    than the straight way there; if that is more than the best one costs, the search need not go on. The first limit is
    what the search before needed, and a little more: between two of them, map and robot change little. If that is too
    little, another search follows, as far as it must. The limits change neither which end is found nor what its path
    costs.
    """

    def __init__(self) -> None:
        load_search()
        self._limit_m = math.inf

    def cheapest(self, start: tuple[int, int], floor: Floor, ends: Indices, beyond_m: Doubles) -> tuple[int, Indices]:
        """Return which of the ``ends``, (n, 2), is cheapest, and the rows and columns of the path to it, (m, 2).

        All of them can be reached. ``beyond_m``: (n,), what each costs in addition to its path.
        """
        down, right = np.abs(ends - start).T
        straight_m = floor.cell_m * np.maximum(down + _BEND * right, right + _BEND * down)
        cost_m = np.empty(len(ends))
        limit_m = self._limit_m
        while True:
            corner, paths = _paths_within(limit_m, start, floor)
            is_near = straight_m <= limit_m
            cost_m.fill(math.inf)
            cost_m[is_near] = paths.cost_m[tuple((ends[is_near] - corner).T)] + beyond_m[is_near]
            best = int(np.argmin(cost_m))
            needed_m = cost_m[best] - beyond_m[straight_m + beyond_m <= cost_m[best] + _EXACT_M].min() + _EXACT_M
            if needed_m <= limit_m:
                break
            limit_m = needed_m
        self._limit_m = needed_m + _SPARE_M
        return best, paths.to(*(ends[best] - corner)) + corner


def _paths_within(limit_m: float, start: tuple[int, int], floor: Floor) -> tuple[tuple[int, int], Paths]:
    """Return the paths that cost at most so much, on a part of the grid, and the row and column where that begins."""
    (row, col), (rows, cols) = start, floor.window
    if math.isfinite(limit_m):
        reach = math.ceil(limit_m / floor.cell_m)
        rows = slice(max(row - reach, rows.start), min(row + reach + 1, rows.stop))
        cols = slice(max(col - reach, cols.start), min(col + reach + 1, cols.stop))
    here, part = (row - rows.start, col - cols.start), (rows, cols)
    paths = cheapest_paths(here, floor.reached[part], floor.price(part), floor.cell_m, limit_m)
    return (rows.start, cols.start), paths


def connected(start: tuple[int, int], cells: Bools) -> tuple[Bools, Window]:
    """Return the ``cells`` (rows, cols) that neighbours connect with one, and the smallest window that holds them.

    Neighbours are the eight around a cell.
    """
    filled = cells.astype(np.uint8)
    col, row, n_cols, n_rows = cv2.floodFill(filled, None, start[::-1], 2, flags=8)[3]
    return np.asarray(filled == 2), (slice(row, row + n_rows), slice(col, col + n_cols))


def cell_below(map: LocalMap) -> tuple[int, int]:  # noqa: A002  # the port's name
    """Return the row and the column of the cell below the robot's centre, on the grid's rim if that is outside."""
    rows, cols = map.state.shape
    row, col = round((map.y_m - map.origin_y_m) / map.cell_m), round((map.x_m - map.origin_x_m) / map.cell_m)
    return min(max(row, 0), rows - 1), min(max(col, 0), cols - 1)


def beside(cells: Bools) -> Bools:
    """Return the ``cells`` (rows, cols), and which have one of them above, below, to the left or right."""
    return np.asarray(cv2.dilate(cells.view(np.uint8), _CROSS).view(np.bool_))
