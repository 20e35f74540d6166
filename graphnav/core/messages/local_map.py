"""The map of a robot's surroundings that it makes from what it sees while it drives."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar, Self

import graphnav_lcm
import numpy as np

from graphnav.arrays import Bools, Bytes, Doubles, Floats, Indices
from graphnav.core.messages.derived import Derived
from graphnav.core.messages.message import FieldError, Message

_MAX_CELLS = 4096
_MIN_CELL_M, _MAX_CELL_M = 1e-4, 1e3
"""Limits of what is received: stages take steps of half a cell."""
_obstacle_m: Derived[Floats] = Derived()
_unknown_m: Derived[Floats] = Derived()
"""Distances of the maps of this process, by their states and the sizes of their cells."""


class LocalMap(Message, lcm=graphnav_lcm.floor_map_t, former=(graphnav_lcm.local_map_t,)):
    """The floor around the robot, as far as it is known: a grid that moves with the robot and does not turn with it.

    The frame of the map is the robot's at its start (x forward, y left). Cell (r, c) has its middle at
    x = origin_x_m + c * cell_m, y = origin_y_m + r * cell_m. ``x_m``, ``y_m``, ``yaw_rad``: pose of the robot.
    ``state``: uint8 (rows, cols), 0 unknown, 1 free, 2 obstacle, 3 obstacle that moves or floor that it will reach.

    The distances ``obstacle_m`` and ``unknown_m`` are not sent: they are computed from the state where they are read
    first, once for all stages of a process that get this map. The state must not change any more by then.
    """

    UNKNOWN: ClassVar[int] = 0
    FREE: ClassVar[int] = 1
    OBSTACLE: ClassVar[int] = 2
    MOVING: ClassVar[int] = 3
    """The values of ``state``."""

    cell_m: float
    origin_x_m: float
    origin_y_m: float
    x_m: float
    y_m: float
    yaw_rad: float
    state: Bytes

    @classmethod
    def from_lcm_fields(cls, values: Mapping[str, Any]) -> Self:
        """Return the map of ``floor_map_t``, or of ``local_map_t``, whose distances are not read.

        Raises
        ------
        FieldError
            It has fewer than 2 or more than 4096 cells to a side, cells smaller than 0.1 mm or larger than 1 km,
            a state that is not one of the four, or the robot is not on it.
        """
        found = super().from_lcm_fields(values)
        rows, cols = found.state.shape
        for name, count in (("rows", rows), ("cols", cols)):
            if not 2 <= count <= _MAX_CELLS:
                raise FieldError(name, count, f"2 to {_MAX_CELLS}")
        if not _MIN_CELL_M <= found.cell_m <= _MAX_CELL_M:
            raise FieldError("cell_m", f"{found.cell_m:g}", f"{_MIN_CELL_M:g} to {_MAX_CELL_M:g}")
        if found.state.max() > cls.MOVING:
            raise FieldError("the largest state", found.state.max(), f"0 to {cls.MOVING}")
        for name, size, at_m in (("x", cols, found.x_m - found.origin_x_m), ("y", rows, found.y_m - found.origin_y_m)):
            if not -1.0 <= at_m / found.cell_m <= size:
                on_map_m = f"{-found.cell_m:g} to {size * found.cell_m:g}, on the map"
                raise FieldError(f"{name}_m - origin_{name}_m", f"{at_m:g}", on_map_m)
        return found

    @property
    def obstacle_m(self) -> Floats:
        """Distance from the middle of every cell to the rim of the nearest obstacle, moving or not.

        float32 (rows, cols), metres, read-only; at most the diagonal of the grid.
        """
        return _obstacle_m.of((self.state,), self.cell_m, lambda: _rim_m(self.state >= self.OBSTACLE, self.cell_m))

    @property
    def unknown_m(self) -> Floats:
        """Distance from the middle of every cell to the rim of the nearest unknown cell, as ``obstacle_m``."""
        return _unknown_m.of((self.state,), self.cell_m, lambda: _rim_m(self.state == self.UNKNOWN, self.cell_m))

    def cells_at(self, forward_m: Doubles, left_m: Doubles) -> tuple[Indices, Indices]:
        """Return the rows and columns of the cells at points in the robot's frame (any shape), clipped to the grid."""
        c, s = np.cos(self.yaw_rad), np.sin(self.yaw_rad)
        return self.cells_of(self.x_m + c * forward_m - s * left_m, self.y_m + s * forward_m + c * left_m)

    def cells_of(self, x_m: Doubles, y_m: Doubles) -> tuple[Indices, Indices]:
        """Return the rows and columns of the cells at points in the map's frame (any shape), clipped to the grid."""
        rows, cols = self.state.shape
        row = np.clip(np.rint((y_m - self.origin_y_m) / self.cell_m), 0, rows - 1).astype(np.intp)
        col = np.clip(np.rint((x_m - self.origin_x_m) / self.cell_m), 0, cols - 1).astype(np.intp)
        return row, col

    def places_m(self, rows: Indices, cols: Indices) -> tuple[Doubles, Doubles]:
        """Return the middles of cells in the map's frame, x and y."""
        return np.asarray(self.origin_x_m + cols * self.cell_m), np.asarray(self.origin_y_m + rows * self.cell_m)

    def obstacle_m_at(self, forward_m: Doubles, left_m: Doubles) -> Doubles:
        """Return the distance to the nearest obstacle from points in the robot's frame, interpolated."""
        return self._interpolated(self.obstacle_m, forward_m, left_m)

    def unknown_m_at(self, forward_m: Doubles, left_m: Doubles) -> Doubles:
        """Return the distance to the nearest unknown cell from points in the robot's frame, interpolated."""
        return self._interpolated(self.unknown_m, forward_m, left_m)

    def _interpolated(self, values: Floats, forward_m: Doubles, left_m: Doubles) -> Doubles:
        c, s = np.cos(self.yaw_rad), np.sin(self.yaw_rad)
        rows, cols = values.shape
        x = np.clip((self.x_m + c * forward_m - s * left_m - self.origin_x_m) / self.cell_m, 0, cols - 1.001)
        y = np.clip((self.y_m + s * forward_m + c * left_m - self.origin_y_m) / self.cell_m, 0, rows - 1.001)
        col, row = x.astype(np.intp), y.astype(np.intp)
        along, down = x - col, y - row
        upper = values[row, col] * (1 - along) + values[row, col + 1] * along
        lower = values[row + 1, col] * (1 - along) + values[row + 1, col + 1] * along
        return np.asarray(upper * (1 - down) + lower * down)


def _rim_m(there: Bools, cell_m: float) -> Floats:
    """Return the distance from the middle of every cell to the rim of the nearest one ``there``, or across the grid."""
    import cv2  # noqa: PLC0415  # slow to load, and not needed by what only names messages

    across = np.float32(math.hypot(*there.shape))
    away = (~there).view(np.uint8)
    # All others are there: so is the rim of the box, and nothing beyond it is nearer.
    left, top, width, height = cv2.boundingRect(away)
    inner = np.s_[max(top - 1, 0) : top + height + 1, max(left - 1, 0) : left + width + 1]
    apart: Floats = cv2.distanceTransform(away[inner], cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    # OpenCV's last bit depends on where memory lies. The square of a distance between cells is an integer.
    np.minimum(apart, across, out=apart)
    np.square(apart, out=apart)
    np.sqrt(np.rint(apart, out=apart), out=apart)
    apart -= np.float32(0.5)
    apart *= np.float32(cell_m)
    rim_m = np.zeros(there.shape, np.float32)
    np.clip(apart, np.float32(0.0), np.float32(cell_m * math.hypot(*there.shape)), out=rim_m[inner])
    rim_m.setflags(write=False)
    return rim_m
