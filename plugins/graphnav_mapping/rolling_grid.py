"""Evidence of obstacles on a grid that moves along with the robot, and the map that it makes."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple, TypeVar

import cv2
import numpy as np
import numpy.typing as npt

from graphnav import LocalMap, Motion, ParamError
from graphnav.arrays import Bools, Bytes, Doubles, Floats, Indices

Layer = TypeVar("Layer", Floats, Bools)
GROUND, OBSTACLE = 1, 2
"""Labels of a picture's cells; 0 is not judged."""
_MIN_CELLS, _MAX_CELLS = 8, 2000


class Box(NamedTuple):
    """A rectangle of cells: from its first row and column up to those after its last."""

    top: int
    left: int
    bottom: int
    right: int

    @property
    def cells(self) -> tuple[slice, slice]:
        """The index of its cells."""
        return slice(self.top, self.bottom), slice(self.left, self.right)

    @property
    def shape(self) -> tuple[int, int]:
        """How many rows and columns it has."""
        return self.bottom - self.top, self.right - self.left

    def grown(self, by: int) -> Box:
        """Return it with so many more rows and columns on each side."""
        return Box(self.top - by, self.left - by, self.bottom + by, self.right + by)

    def within(self, other: Box) -> Box:
        """Return the part that is in another one, of no cells where they do not overlap."""
        top, left = max(self.top, other.top), max(self.left, other.left)
        return Box(top, left, max(top, min(self.bottom, other.bottom)), max(left, min(self.right, other.right)))

    def moved(self, down: int, right: int) -> Box:
        """Return it moved by cells."""
        return Box(self.top + down, self.left + right, self.bottom + down, self.right + right)


class RollingGrid:
    """Log-odds that a cell of the floor holds an obstacle, ``evidence``; 0 is unknown.

    ``shown``: in how many full frames each cell was an obstacle, less those in which it was ground. ``forgotten``:
    where obstacles were forgotten.

    The grid keeps the orientation that the robot had at its start. It is shifted by cells when the robot has left its
    middle.

    Parameters
    ----------
    size_m
        Side of the grid, rounded up to full cells.
    cell_m
        Side of a cell.
    """

    def __init__(self, size_m: float, cell_m: float) -> None:
        cells = _cells(size_m, cell_m)
        self.cell_m = cell_m
        self.evidence: Floats = np.zeros((cells, cells), np.float32)
        self.shown: Floats = np.zeros((cells, cells), np.float32)
        self.forgotten: Bools = np.zeros((cells, cells), np.bool_)
        self._middle_m = (cells - 1) / 2 * cell_m
        self.origin_x_m = self.origin_y_m = -self._middle_m
        self.x_m = self.y_m = self.yaw_rad = 0.0
        self.corner = (0, 0)

    @staticmethod
    def check(size_m: float, cell_m: float) -> None:
        """Raise ParamError for a grid that is too coarse or too fine for its size."""
        cells = _cells(size_m, cell_m)
        if not _MIN_CELLS <= cells <= _MAX_CELLS:
            what = f"'size_m' {size_m:g} and 'cell_m' {cell_m:g} give a map of {cells} cells to a side"
            raise ParamError("size_m", what, f"choose them for {_MIN_CELLS} to {_MAX_CELLS} cells")

    def move(self, motion: Motion) -> None:
        """Move the robot by a displacement in the frame that it had before, and turn it."""
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        self.x_m += c * motion.forward_m - s * motion.left_m
        self.y_m += s * motion.forward_m + c * motion.left_m
        self.yaw_rad = math.remainder(self.yaw_rad + motion.turn_rad, 2 * math.pi)
        right = round((self.x_m - self.origin_x_m - self._middle_m) / self.cell_m)
        down = round((self.y_m - self.origin_y_m - self._middle_m) / self.cell_m)
        if max(abs(right), abs(down)) > len(self.evidence) // 8:
            self._shift(right, down)

    def to_robot(self) -> Doubles:
        """Return the matrix (3, 3) from cells (column, row, 1) to floor points (x, y, 1) in the robot's frame."""
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        turned = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        x_m, y_m = self.origin_x_m - self.x_m, self.origin_y_m - self.y_m
        placed = np.array([[self.cell_m, 0.0, x_m], [0.0, self.cell_m, y_m], [0.0, 0.0, 1.0]])
        matrix: Doubles = turned @ placed
        return matrix

    @property
    def box(self) -> Box:
        """All of its cells."""
        return Box(0, 0, *self.evidence.shape)

    def stand(self, radius_m: float, evidence: float) -> None:
        """Give the floor below the robot, a disc, the evidence of free floor."""
        disc = _disc(math.ceil(radius_m / self.cell_m))
        radius = len(disc) // 2
        row, col = round((self.y_m - self.origin_y_m) / self.cell_m), round((self.x_m - self.origin_x_m) / self.cell_m)
        around = Box(row, col, row + 1, col + 1).grown(radius)
        inside = around.within(self.box)
        self.evidence[inside.cells][disc[inside.moved(-around.top, -around.left).cells]] = evidence

    def to_map(self, state: Bytes) -> LocalMap:
        """Return the map with the state of every cell, (rows, cols)."""
        return LocalMap(
            cell_m=self.cell_m,
            origin_x_m=self.origin_x_m,
            origin_y_m=self.origin_y_m,
            x_m=self.x_m,
            y_m=self.y_m,
            yaw_rad=self.yaw_rad,
            state=state,
        )

    def box_of(self, points_m: Doubles) -> Box:
        """Return the box of all points (n, 2) of the floor in the robot's frame, a cell wider on each side."""
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        turned = points_m @ np.array([[c, s], [-s, c]]) + (self.x_m - self.origin_x_m, self.y_m - self.origin_y_m)
        (left, top), (right, bottom) = (
            np.floor(turned.min(axis=0) / self.cell_m),
            np.ceil(turned.max(axis=0) / self.cell_m),
        )
        return Box(int(top) - 1, int(left) - 1, int(bottom) + 2, int(right) + 2).within(self.box)

    def shown_by(self, shape: tuple[int, int], floor_to_cells: Doubles, box: Box) -> Indices:
        """Return which cell of a picture shows each cell of a box, 0 where none does, else its number from 1 on.

        ``shape``: rows and columns of the picture's cells, which count along the rows; ``floor_to_cells``: homography
        from floor points in the robot's frame to these.
        """
        to_grid = np.array([[1.0, 0.0, box.left], [0.0, 1.0, box.top], [0.0, 0.0, 1.0]])
        rows, cols = box.shape
        if not rows or not cols:
            return np.zeros((rows, cols), np.intp)
        found = cv2.warpPerspective(
            _numbers(*shape),
            floor_to_cells @ self.to_robot() @ to_grid,
            (cols, rows),
            flags=cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=0,
        )
        return np.asarray(found, np.intp)

    def _shift(self, right: int, down: int) -> None:
        """Move the grid by cells, so that the robot is in its middle again."""
        self.evidence = shifted(self.evidence, right, down)
        self.shown = shifted(self.shown, right, down)
        self.forgotten = shifted(self.forgotten, right, down)
        self.corner = self.corner[0] + right, self.corner[1] + down
        self.origin_x_m += right * self.cell_m
        self.origin_y_m += down * self.cell_m


def shifted(values: Layer, right: int, down: int) -> Layer:
    """Return the values (rows, cols) of a grid that was moved by cells, 0 where they are new."""
    n_rows, n_cols = values.shape
    right, down = max(-n_cols, min(right, n_cols)), max(-n_rows, min(down, n_rows))
    moved = np.zeros_like(values)
    rows, cols = slice(max(down, 0), n_rows + min(down, 0)), slice(max(right, 0), n_cols + min(right, 0))
    to_rows, to_cols = slice(max(-down, 0), n_rows - max(down, 0)), slice(max(-right, 0), n_cols - max(right, 0))
    moved[to_rows, to_cols] = values[rows, cols]
    return moved


@lru_cache(maxsize=16)
def _numbers(rows: int, cols: int) -> npt.NDArray[np.int32]:
    return np.arange(1, rows * cols + 1, dtype=np.int32).reshape(rows, cols)


@lru_cache(maxsize=16)
def _disc(radius: int) -> Bools:
    disc = np.zeros((2 * radius + 1, 2 * radius + 1), np.uint8)
    cv2.circle(disc, (radius, radius), radius, 1, cv2.FILLED)
    return disc.view(np.bool_)


def without_jump(motion: Motion, size_m: float) -> Motion:
    """Return the motion on a map of this side; none if it is longer than half of the map.

    Odometry that jumps so far does not tell where the robot is on the map.
    """
    is_jump = math.hypot(motion.forward_m, motion.left_m) > size_m / 2
    return replace(motion, forward_m=0.0, left_m=0.0, turn_rad=0.0) if is_jump else motion


def _cells(size_m: float, cell_m: float) -> int:
    return math.ceil(size_m / cell_m)
