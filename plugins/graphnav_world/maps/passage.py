"""Where a round robot can go: the map from above, inflated by its radius, on a grid."""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator

import cv2
import numpy as np

from graphnav.arrays import Bools, Doubles, Floats
from graphnav_world.geometry import outlines
from graphnav_world.geometry.scene import Body, Kind

CELL_M = 0.025
MAX_CELLS = 1_000_000
"""Of a grid: with cells of 2.5 cm 625 square metres, margins included."""
STRIDE = 2
STEPS = [(down, right, math.hypot(down, right)) for down in (-1, 0, 1) for right in (-1, 0, 1)]
"""Of the search, in strides: down, right, length."""
MARGIN_M = 1.0
Cell = tuple[int, int]


class Passage:
    """Searches ways from a start to a goal region; moving obstacles are left out.

    The grid has cells of 2.5 cm, larger ones if there would be more than a million. A way may leave the map's bounds by
    one metre less the robot's radius.
    """

    def __init__(self, bodies: list[Body], start: tuple[float, float, float], goal_m: Doubles) -> None:
        self._standing = [body for body in bodies if body.kind != Kind.MOVING]
        self._moving = [body for body in bodies if body.kind == Kind.MOVING]
        self._start, self._goal = start, goal_m
        points = np.concatenate([[start[:2]], goal_m, *(body.outline for body in self._standing)])
        self._corner = points.min(axis=0) - MARGIN_M
        size_m = points.max(axis=0) + MARGIN_M - self._corner
        self._cell_m = max(CELL_M, math.sqrt(size_m[0] * size_m[1] / MAX_CELLS))
        cols, rows = np.ceil(size_m / self._cell_m).astype(int) + 1
        self.n_cells = int(cols * rows)
        free = np.ones((rows, cols), np.uint8)
        for body in self._standing:
            for part in body.parts:
                cv2.fillConvexPoly(free, np.round(self._cells(part) * 16).astype(np.int32), 0, shift=4)
        self._clearance_m: Floats = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * self._cell_m
        in_goal = np.zeros((rows, cols), np.uint8)
        if len(goal_m):
            cv2.fillPoly(in_goal, [np.round(self._cells(goal_m) * 16).astype(np.int32)], 1, shift=4)
        self._in_goal = in_goal.astype(bool)

    def touched_at_start(self, radius_m: float) -> Body | None:
        """Return the first body that a robot of this radius touches at the start."""
        x, y, _ = self._start
        for body in (*self._standing, *self._moving):
            at = body.course.at(0.0) if body.course else np.zeros(2)
            if any(outlines.distance(part + at, x, y) < radius_m for part in body.parts):
                return body
        return None

    def leads_to_goal(self, radius_m: float) -> bool:
        """Whether a robot of this radius finds a way."""
        free = (self._clearance_m > radius_m).astype(np.uint8)
        row, col = self._start_cell()
        free[row, col] = 1
        _, label = cv2.connectedComponents(free, connectivity=4)
        return bool((self._in_goal & (label == label[row, col])).any())

    def straight_is_blocked(self, radius_m: float) -> bool:
        """Whether a robot of this radius reaches the goal neither straight ahead nor straight to its middle."""
        x, y, yaw = self._start
        to_middle = self._goal.mean(axis=0) - (x, y)
        ahead = np.array([math.cos(yaw), math.sin(yaw)])
        return not any(self._is_free_to_goal(way / np.linalg.norm(way), radius_m) for way in (to_middle, ahead))

    def _is_free_to_goal(self, direction: Doubles, radius_m: float) -> bool:
        rows, cols = self._in_goal.shape
        steps = np.arange(rows + cols)[:, None] * self._cell_m
        col, row = np.round(self._cells(np.array(self._start[:2]) + steps * direction)).astype(int).T
        inside = (col >= 0) & (row >= 0) & (col < cols) & (row < rows)
        col, row = col[inside], row[inside]
        arrived = np.flatnonzero(self._in_goal[row, col])
        if not len(arrived):
            return False
        before = self._clearance_m[row[: arrived[0]], col[: arrived[0]]]
        return bool((before > radius_m - self._cell_m).all())

    def shortest_m(self, radius_m: float) -> float:
        """Return the length of the shortest way, found on the grid and pulled taut; 0 if there is none."""
        free = self._clearance_m > radius_m
        way = self._search(free)
        if not way:
            return 0.0
        taut = [way[0]]
        here = 0
        while here < len(way) - 1:
            here = next(k for k in range(len(way) - 1, here, -1) if k == here + 1 or _sees(free, way[here], way[k]))
            taut.append(way[here])
        return float(np.linalg.norm(np.diff(np.array(taut), axis=0), axis=1).sum() * self._cell_m)

    def _search(self, free: Bools) -> list[Cell]:
        """Return the cells of a shortest 8-connected way (Dijkstra), empty if there is none.

        It takes every second row and column, those of the start, and numbers their cells row by row.
        """
        row, col = self._start_cell()
        top, left = row % STRIDE, col % STRIDE
        reachable = np.pad(free[top::STRIDE, left::STRIDE], 1)  # the rim is not free
        in_goal = np.pad(self._in_goal[top::STRIDE, left::STRIDE], 1).ravel().tolist()
        best = np.where(reachable, math.inf, -math.inf).ravel().tolist()
        cols = reachable.shape[1]
        steps = [(down * cols + right, STRIDE * length) for down, right, length in STEPS]
        start = (row // STRIDE + 1) * cols + col // STRIDE + 1
        best[start] = 0.0
        came: dict[int, int] = {}
        queue = [(0.0, start)]
        while queue:
            length, cell = heapq.heappop(queue)
            if length > best[cell]:
                continue
            if in_goal[cell]:
                way = [*reversed(list(_back(came, cell)))]
                return [((one // cols - 1) * STRIDE + top, (one % cols - 1) * STRIDE + left) for one in way]
            for step, step_length in steps:
                near, reached = cell + step, length + step_length
                if reached < best[near]:
                    best[near], came[near] = reached, cell
                    heapq.heappush(queue, (reached, near))
        return []

    def _start_cell(self) -> Cell:
        col, row = np.round(self._cells(np.array([self._start[:2]]))[0]).astype(int)
        return int(row), int(col)

    def _cells(self, points_m: Doubles) -> Doubles:
        """Return grid coordinates (col, row)."""
        cells: Doubles = (points_m - self._corner) / self._cell_m
        return cells


def _back(came: dict[int, int], cell: int) -> Iterator[int]:
    yield cell
    while cell in came:
        cell = came[cell]
        yield cell


def _sees(free: Bools, a: Cell, b: Cell) -> bool:
    """Whether the straight line between two cells is free."""
    steps = max(abs(a[0] - b[0]), abs(a[1] - b[1])) * 2
    rows = np.round(np.linspace(a[0], b[0], steps + 1)).astype(int)
    cols = np.round(np.linspace(a[1], b[1], steps + 1)).astype(int)
    return bool(free[rows, cols].all())
