"""The way that is left to a goal, on a map of cells: how far a drive has come."""

from __future__ import annotations

import itertools
import math

import numpy as np
from PIL import Image as Picture
from PIL import ImageDraw
from scipy.ndimage import distance_transform_edt
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from graphnav import Map, Scene, State
from graphnav.arrays import Bools, Doubles

_MAX_CELLS = 40_000
_CELL_M = 0.1
"""Cells are larger on maps that would have more than the maximum."""
_STEPS = [(r, c) for r, c in itertools.product((0, 1), (-1, 0, 1)) if (r, c) > (0, 0)]
"""To half of the neighbours of a cell: ways have no direction."""


class Progress:
    """How much shorter the way to the goal has become since the last look, metres; without a goal the distance driven.

    The way is the shortest among the fixed obstacles for a disc as wide as the robot, over cells of 0.1 m and their
    diagonals, at most 8 % longer than the true one. Moving obstacles are not on it.
    """

    def __init__(self, world: Map) -> None:
        self._scene = Scene(world)
        self._has_goal = len(world.goal_m) > 0
        self._last: float | None = None
        self._place_m = (math.nan, math.nan)
        if self._has_goal:
            self._measure(world)

    def advance(self, state: State) -> float:
        """Return the progress since the last state, metres; 0 at the first."""
        place_m = (state.x_m, state.y_m)
        if not self._has_goal:
            driven_m = 0.0 if self._last is None else math.dist(place_m, self._place_m)
            self._place_m, self._last = place_m, 0.0
            return driven_m
        left_m = self._left_at(*place_m)
        before_m, self._last = self._last, left_m
        return 0.0 if before_m is None else before_m - left_m

    def _measure(self, world: Map) -> None:
        """Find the length of the way from every cell that a robot can be in."""
        low, high = self._scene.bounds_m([], np.zeros((0, 0, 3)), 4 * _CELL_M)
        self._cell_m = max(_CELL_M, math.sqrt(float(np.prod(high - low)) / _MAX_CELLS))
        self._low_m = low
        self._size = rows, cols = tuple((np.ceil((high - low) / self._cell_m).astype(int) + 1)[::-1].tolist())
        solid = self._filled(area.outline_m for area in self._scene.fixed if area.role != "goal")
        clear_m = distance_transform_edt(~solid) * self._cell_m
        goal = self._filled([world.goal_m])
        if not goal.any():
            at = np.rint((world.goal_m.mean(axis=0) - low) / self._cell_m).astype(int)
            goal[min(at[1], rows - 1), min(at[0], cols - 1)] = True
        free = (clear_m >= world.robot_radius_m - self._cell_m / 2) | goal
        left_m = _ways(free, goal) * self._cell_m
        straight_m = distance_transform_edt(~goal) * self._cell_m
        # where no way is known (in an obstacle's rim) the nearest cell that has one says it
        at_hand = distance_transform_edt(~np.isfinite(left_m), return_distances=False, return_indices=True)
        nearest: Doubles = left_m[tuple(at_hand)]
        self._left_m = np.where(np.isfinite(nearest), nearest, straight_m)

    def _left_at(self, x_m: float, y_m: float) -> float:
        """Return the length of the way from a point, interpolated."""
        rows, cols = self._left_m.shape
        x = min(max((x_m - self._low_m[0]) / self._cell_m, 0.0), cols - 1.001)
        y = min(max((y_m - self._low_m[1]) / self._cell_m, 0.0), rows - 1.001)
        c, r = int(x), int(y)
        x, y = x - c, y - r
        left = self._left_m[r : r + 2, c : c + 2]
        upper, lower = left[0, 0] * (1 - x) + left[0, 1] * x, left[1, 0] * (1 - x) + left[1, 1] * x
        return float(upper * (1 - y) + lower * y)

    def _filled(self, outlines_m: object) -> Bools:
        """Return the cells in areas."""
        picture = Picture.new("1", self._size[::-1])
        draw = ImageDraw.Draw(picture)
        for outline_m in outlines_m:  # type: ignore[attr-defined]
            draw.polygon([tuple(point) for point in ((outline_m - self._low_m) / self._cell_m).tolist()], fill=1)
        return np.array(picture, bool)


def _ways(free: Bools, goal: Bools) -> Doubles:
    """Return the length of the way from each cell to the goal, cells; infinite where there is none."""
    number = np.arange(free.size).reshape(free.shape)
    rows, cols = free.shape
    begins, ends, lengths = [], [], []
    for r, c in _STEPS:
        here = (slice(0, rows - r), slice(max(0, -c), cols - max(0, c)))
        there = (slice(r, rows), slice(max(0, c), cols - max(0, -c)))
        both = free[here] & free[there]
        begins.append(number[here][both])
        ends.append(number[there][both])
        lengths.append(np.full(np.count_nonzero(both), math.hypot(r, c)))
    pairs = (np.concatenate(begins), np.concatenate(ends))
    edges = coo_matrix((np.concatenate(lengths), pairs), (free.size, free.size)).tocsr()
    from_goal = dijkstra(edges, directed=False, indices=number[goal], min_only=True)
    found: Doubles = np.asarray(from_goal).reshape(free.shape)
    return found
