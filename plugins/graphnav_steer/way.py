"""Cheapest path to the goal from every point of the true map: a grid, its clearance, its costs."""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator

import cv2
import numpy as np

from graphnav import Map
from graphnav.arrays import Bools, Bytes, Doubles

CELL_M = 0.05
BEYOND_M = 1.0
"""Margin of the grid around the map."""
INSIDE_M = 0.1
"""Depth inside the goal region at which paths end: the region's rim is accurate to a cell."""
TOO_NEAR = 100.0
"""Cost of a metre in collision, relevant only for a robot that is already there."""
STEPS = [
    (down, right, math.hypot(down, right))
    for down in range(-2, 3)
    for right in range(-2, 3)
    if math.gcd(down, right) == 1
]
"""Steps of the search, in cells: down, right, length; sixteen directions."""


class Way:
    """Costs to the goal region, by Dijkstra's algorithm on a grid of 5 cm over the inflated map.

    A metre costs 1, and more where the robot's rim is nearer than ``comfort_m`` to a body: ``1 + wall_cost`` at
    contact, falling with the square. Moving obstacles are ignored.

    Raises
    ------
    ValueError
        The map has no goal.
    """

    def __init__(self, world: Map, comfort_m: float, wall_cost: float) -> None:
        if not len(world.goal_m):
            raise ValueError("the map has no goal to plan a way to: use a map with a goal")
        world = world.surroundings()
        points_m = np.concatenate([world.vertices_m, world.goal_m, world.start[None, :2]])
        self._corner_m = points_m.min(axis=0) - BEYOND_M
        cols, rows = np.ceil((points_m.max(axis=0) + BEYOND_M - self._corner_m) / CELL_M).astype(int) + 1
        free = np.ones((rows, cols), np.uint8)
        for body in np.flatnonzero(world.kind != Map.MOVING):
            self._fill(free, world.vertices_m[world.body == body], 0)
        clearance_m = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * CELL_M - world.robot_radius_m
        near = np.clip(1.0 - clearance_m / comfort_m, 0.0, 1.0)
        price = np.where(clearance_m > 0.0, 1.0 + wall_cost * near**2, TOO_NEAR)
        goal = np.zeros((rows, cols), np.uint8)
        self._fill(goal, world.goal_m, 1)
        depth_m = cv2.distanceTransform(goal & free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * CELL_M
        arrived = depth_m >= min(INSIDE_M, depth_m.max())
        # A rim of two impassable cells saves the check whether a step leaves the grid.
        self._price = np.full_like(price, math.inf)
        inner = (slice(2, -2), slice(2, -2))
        self._price[inner] = np.where(free, price, math.inf)[inner]
        self._cost = _costs(self._price, arrived & np.isfinite(self._price))

    def ahead(self, x_m: float, y_m: float, distance_m: float) -> Doubles:
        """Return the point, (2,) in W, at this distance along the path, or the path's end if that is nearer.

        Without a path the point itself is returned.
        """
        here = np.array([x_m, y_m])
        row, col = self._cell(here)
        while math.isfinite(self._cost[row, col]) and self._cost[row, col] > 0.0:
            _, row, col = min(self._steps_from(row, col))
            if np.hypot(*(self._place_m(row, col) - here)) >= distance_m:
                break
        return self._place_m(row, col)

    def cost(self, x_m: float, y_m: float) -> float:
        """Return the cost of the path from here, infinite if there is none."""
        return float(self._cost[self._cell(np.array([x_m, y_m]))])

    def _steps_from(self, row: int, col: int) -> Iterator[tuple[float, int, int]]:
        """Yield the cost by way of each neighbour, and the neighbour's row and column."""
        for down, right, length in STEPS:
            near = row + down, col + right
            step_m = length * CELL_M / 2 * (self._price[row, col] + self._price[near])
            yield float(step_m + self._cost[near]), *near

    def _cell(self, place_m: Doubles) -> tuple[int, int]:
        """Return the row and column of a point, clipped to the grid."""
        rows, cols = self._cost.shape
        col, row = np.clip(np.round(self._cells(place_m)), 0, (cols - 1, rows - 1)).astype(int)
        return int(row), int(col)

    def _fill(self, grid: Bytes, outline_m: Doubles, value: int) -> None:
        cv2.fillPoly(grid, [np.round(self._cells(outline_m) * 16).astype(np.int32)], value, shift=4)

    def _cells(self, points_m: Doubles) -> Doubles:
        """Return grid coordinates (col, row)."""
        cells: Doubles = (points_m - self._corner_m) / CELL_M
        return cells

    def _place_m(self, row: int, col: int) -> Doubles:
        place: Doubles = self._corner_m + CELL_M * np.array([col, row])
        return place


def _costs(price: Doubles, goal: Bools) -> Doubles:
    """Return the cost from every cell to the cells of ``goal``, metres times ``price`` (infinite: impassable)."""
    rows, cols = price.shape
    cost = [math.inf] * (rows * cols)
    prices = price.reshape(-1).tolist()
    queue = [(0.0, int(cell)) for cell in np.flatnonzero(goal)]
    for _, cell in queue:
        cost[cell] = 0.0
    steps = [(down * cols + right, length * CELL_M / 2) for down, right, length in STEPS]
    while queue:
        here, cell = heapq.heappop(queue)
        if here > cost[cell]:
            continue
        price_here = prices[cell]
        for offset, half_m in steps:
            near = cell + offset
            there = here + half_m * (price_here + prices[near])
            if there < cost[near]:
                cost[near] = there
                heapq.heappush(queue, (there, near))
    return np.array(cost).reshape(rows, cols)
