"""Evidence of obstacles on a grid that moves along with the robot."""

from __future__ import annotations

import math

import cv2
import numpy as np

from graphnav.arrays import Bytes, Doubles, Floats

GROUND, OBSTACLE = 1, 2
"""Labels of a picture's cells; 0 is not judged."""


class RollingGrid:
    """Log-odds that a cell of the floor holds an obstacle; 0 is unknown.

    The grid keeps the orientation that the robot had at its start. It is shifted by cells when the robot has left its
    middle.

    Parameters
    ----------
    cells
        Cells to a side.
    cell_m
        Side of a cell.
    """

    def __init__(self, cells: int, cell_m: float) -> None:
        self.cell_m = cell_m
        self.evidence: Floats = np.zeros((cells, cells), np.float32)
        self._middle_m = (cells - 1) / 2 * cell_m
        self.origin_x_m = self.origin_y_m = -self._middle_m
        self.x_m = self.y_m = self.yaw_rad = 0.0
        self.corner = (0, 0)

    def move(self, forward_m: float, left_m: float, turn_rad: float) -> None:
        """Move the robot by a displacement in the frame that it had before, and turn it."""
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        self.x_m += c * forward_m - s * left_m
        self.y_m += s * forward_m + c * left_m
        self.yaw_rad = math.remainder(self.yaw_rad + turn_rad, 2 * math.pi)
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

    def cell(self) -> tuple[int, int]:
        """Return the column and row of the cell below the robot's centre."""
        return round((self.x_m - self.origin_x_m) / self.cell_m), round((self.y_m - self.origin_y_m) / self.cell_m)

    def seen(self, labels: Bytes, floor_to_cells: Doubles) -> Bytes:
        """Return the label of every cell of the grid, 0 where the picture does not show it.

        ``labels``: uint8 (rows, cols) of a picture's cells; ``floor_to_cells``: homography from floor points in the
        robot's frame to these.
        """
        found: Bytes = cv2.warpPerspective(
            labels,
            floor_to_cells @ self.to_robot(),
            self.evidence.shape[::-1],
            flags=cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=0,
        )
        return found

    def _shift(self, right: int, down: int) -> None:
        """Move the grid by cells, so that the robot is in its middle again."""
        size = len(self.evidence)
        moved = np.zeros_like(self.evidence)
        rows, cols = slice(max(down, 0), size + min(down, 0)), slice(max(right, 0), size + min(right, 0))
        to_rows, to_cols = slice(max(-down, 0), size + min(-down, 0)), slice(max(-right, 0), size + min(-right, 0))
        moved[to_rows, to_cols] = self.evidence[rows, cols]
        self.evidence = moved
        self.corner = self.corner[0] + right, self.corner[1] + down
        self.origin_x_m += right * self.cell_m
        self.origin_y_m += down * self.cell_m
