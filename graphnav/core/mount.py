"""How a camera is mounted on the robot: what a pixel sees of the floor, and how the floor flows."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from graphnav.arrays import Doubles
from graphnav.core.messages import Flow, Motion


@dataclass(frozen=True)
class Mount:
    """A pinhole camera ahead of the robot's centre, tilted down; frames R (x forward, y left, z up) and C.

    C has x right, y down, z along the optical axis. Pictures have square pixels and the optical axis in their middle.
    """

    height_m: float
    tilt_deg: float
    fov_deg: float
    forward_m: float

    HEIGHT_DOC: ClassVar[str] = "height of the camera above the floor; all lengths scale with it"
    TILT_DOC: ClassVar[str] = "tilt of the camera below the horizontal; 90 looks straight down"
    FOV_DOC: ClassVar[str] = "horizontal field of view"
    FORWARD_DOC: ClassVar[str] = "distance of the camera before the robot's centre of turning; negative behind it"

    @cached_property
    def R_CR(self) -> Doubles:  # noqa: N802  # the robotics notation for a rotation from R to C
        """Rotation from R to C."""
        c, s = math.cos(math.radians(self.tilt_deg)), math.sin(math.radians(self.tilt_deg))
        return np.array([[0.0, -1.0, 0.0], [-s, 0.0, -c], [c, 0.0, -s]])

    def intrinsics(self, rows: int, cols: int) -> Doubles:
        """Return the matrix (3, 3) from C to pixels of a picture of this size; (0, 0) is the middle of the first."""
        focal_px = cols / 2 / math.tan(math.radians(self.fov_deg) / 2)
        return np.array([[focal_px, 0.0, (cols - 1) / 2], [0.0, focal_px, (rows - 1) / 2], [0.0, 0.0, 1.0]])

    def floor_to_pixels(self, rows: int, cols: int) -> Doubles:
        """Return the homography (3, 3) from floor points (x, y, 1) in R, metres, to pixels (column, row, 1)."""
        from_floor = np.array([[1.0, 0.0, -self.forward_m], [0.0, 1.0, 0.0], [0.0, 0.0, -self.height_m]])
        homography: Doubles = self.intrinsics(rows, cols) @ self.R_CR @ from_floor
        return homography

    def floor_distance_m(self, rows: int, cols: int) -> Doubles:
        """Return how far from the camera's foot each pixel sees the floor, (rows, cols); infinite above the horizon."""
        rays = self.rays(rows, cols) @ self.R_CR
        down = -rays[..., 2]
        with np.errstate(divide="ignore"):
            reach = np.where(down > 0.0, self.height_m / down, np.inf)
        return np.where(down > 0.0, reach * np.hypot(rays[..., 0], rays[..., 1]), np.inf)

    def rays(self, rows: int, cols: int) -> Doubles:
        """Return the ray of each pixel in C, (rows, cols, 3), scaled to a depth of 1."""
        matrix = self.intrinsics(rows, cols)
        x = (np.arange(cols) - matrix[0, 2]) / matrix[0, 0]
        y = (np.arange(rows) - matrix[1, 2]) / matrix[1, 1]
        return np.dstack([*np.meshgrid(x, y), np.ones((rows, cols))])

    def floor_flow(self, rays: Doubles) -> Doubles:
        """Return the flow at ``rays`` (n, 3) to the floor to first order, (5, 2, n), in units of the focal length.

        By 1 m forward, 1 rad of turn, of pitch and of roll, and 1 m to the left.
        """
        R = self.R_CR
        x, y = rays[:, 0], rays[:, 1]
        inverse_depth = np.maximum(-(rays @ R)[:, 2], 0.0) / self.height_m
        forward, left, up = R @ [1.0, 0.0, 0.0], R @ [0.0, 1.0, 0.0], R @ [0.0, 0.0, 1.0]
        xy, xx, yy = x * y, 1 + x * x, 1 + y * y
        fields = np.empty((5, 2, len(rays)))
        for place, (tx, ty, tz) in ((0, forward), (1, self.forward_m * left), (4, left)):
            np.multiply(x * tz - tx, inverse_depth, out=fields[place, 0])
            np.multiply(y * tz - ty, inverse_depth, out=fields[place, 1])
        fields[2:4] = 0.0
        for place, (wx, wy, wz) in ((1, up), (2, left), (3, forward)):
            fields[place, 0] += xy * wx - xx * wy + y * wz
            fields[place, 1] += yy * wx - xy * wy - x * wz
        return fields

    def floor_fields_px(self, flow: Flow) -> Doubles:
        """Return the flow of the floor on the grid of ``flow``, (5, rows * cols, 2), pixels; see `floor_flow`.

        The result is kept for the next flow of this grid; it is read-only.
        """
        rows, cols = flow.valid.shape
        key = rows, cols, flow.step_px
        if key not in self._fields_px:
            self._fields_px.clear()
            focal_px = self.intrinsics(rows, cols)[0, 0] * flow.step_px
            fields_px = focal_px * self.floor_flow(self.rays(rows, cols).reshape(-1, 3)).transpose(0, 2, 1)
            fields_px.setflags(write=False)
            self._fields_px[key] = fields_px
        return self._fields_px[key]

    def floor_moved_px(self, flow: Flow, motion: Motion) -> Doubles:
        """Return the flow that the floor has by a motion, on the grid of ``flow``, (rows * cols, 2), pixels."""
        forward, turn, _, _, left = self.floor_fields_px(flow)
        # To second order the robot moves along the axes that it has midway.
        c, s = math.cos(motion.turn_rad / 2), math.sin(motion.turn_rad / 2)
        forward_m, left_m = c * motion.forward_m + s * motion.left_m, c * motion.left_m - s * motion.forward_m
        return np.asarray(forward_m * forward + left_m * left + motion.turn_rad * turn)

    @cached_property
    def _fields_px(self) -> dict[tuple[int, int, int], Doubles]:
        return {}
