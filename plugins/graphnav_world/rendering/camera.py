"""A pinhole camera on a mast at the robot's centre, looking forward and down."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from graphnav.arrays import Doubles

FARTHEST_FLOOR_M = 20.0


@dataclass(frozen=True)
class Camera:
    """Mounting and projection of the camera.

    C has x right, y down, z along the optical axis. The centre of pixel (r, c) has coordinates x = c, y = r; the
    optical axis meets the middle of the picture. ``tilt_deg`` is measured from the horizontal, down; ``roll_deg`` turns
    the tilted camera about the robot's forward axis, to the right if positive.
    """

    height_m: float = 1.0
    tilt_deg: float = 75.0
    fov_deg: float = 70.0
    cols: int = 160
    rows: int = 120
    roll_deg: float = 0.0

    @property
    def focal_px(self) -> float:
        """Focal length, from the horizontal field of view."""
        return self.cols / 2 / math.tan(math.radians(self.fov_deg) / 2)

    @property
    def center_px(self) -> tuple[float, float]:
        """Principal point: x, y."""
        return (self.cols - 1) / 2, (self.rows - 1) / 2

    @cached_property
    def R_RC(self) -> Doubles:  # noqa: N802  # the robotics notation for a rotation from C to R
        """Return the rotation from C to R; its columns are the camera's axes in the robot's frame."""
        c, s = self._tilt
        tilted = np.array([[0.0, -s, c], [-1.0, 0.0, 0.0], [0.0, -c, -s]])
        if not self.roll_deg:
            return tilted
        c, s = math.cos(math.radians(self.roll_deg)), math.sin(math.radians(self.roll_deg))
        rolled: Doubles = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]) @ tilted
        return rolled

    @cached_property
    def _tilt(self) -> tuple[float, float]:
        """Cosine and sine."""
        return math.cos(math.radians(self.tilt_deg)), math.sin(math.radians(self.tilt_deg))

    def rays(self) -> Doubles:
        """Return the ray of every pixel in C, (rows, cols, 3), scaled to a depth (z) of one."""
        cx, cy = self.center_px
        x, y = np.meshgrid(np.arange(self.cols) - cx, np.arange(self.rows) - cy)
        return np.stack([x / self.focal_px, y / self.focal_px, np.ones_like(x)], axis=-1)

    def pose(self, x_m: float, y_m: float, yaw_rad: float) -> tuple[Doubles, Doubles]:
        """Return (R_WC, position in W) of the camera of a robot at this pose."""
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        position = np.array([x_m, y_m, self.height_m])
        if self.roll_deg:
            return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ self.R_RC, position
        c_tilt, s_tilt = self._tilt
        R_WC = np.array([[s, -c * s_tilt, c * c_tilt], [-c, -s * s_tilt, s * c_tilt], [0.0, -c_tilt, -s_tilt]])
        return R_WC, position

    def project(self, points_C: Doubles) -> Doubles:
        """Return the pixel coordinates (x, y), float64 (..., 2), of points in front of the camera, (..., 3)."""
        pixels: Doubles = points_C[..., :2] / points_C[..., 2:] * self.focal_px + np.array(self.center_px)
        return pixels

    def footprint_m(self, corner_ratio: float = 1.0) -> Doubles:
        """Return the outline of the camera's view on the floor, (4, 2) in R.

        Cut at 20 m: the view of a camera that sees the horizon is unbounded. ``corner_ratio``: how much farther off the
        axis a lens lets the corners look.
        """
        cx, cy = (corner_ratio * half / 2 / self.focal_px for half in (self.cols, self.rows))
        corners = np.array([[-cx, cy, 1.0], [cx, cy, 1.0], [cx, -cy, 1.0], [-cx, -cy, 1.0]]) @ self.R_RC.T
        reach = self.height_m / np.maximum(-corners[:, 2], self.height_m / FARTHEST_FLOOR_M)
        outline: Doubles = corners[:, :2] * reach[:, None]
        return outline
