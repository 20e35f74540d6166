"""How a camera is mounted on the robot: what a pixel sees of the floor."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from graphnav.arrays import Bytes, Doubles, Floats

HEIGHT_DOC = "height of the camera above the floor; all lengths scale with it"
TILT_DOC = "tilt of the camera below the horizontal; 90 looks straight down"
FOV_DOC = "horizontal field of view"
FORWARD_DOC = "distance of the camera before the robot's centre of turning; negative behind it"


@dataclass(frozen=True)
class Mount:
    """A pinhole camera ahead of the robot's centre, tilted down; frames R (x forward, y left, z up) and C.

    C has x right, y down, z along the optical axis. Pictures have square pixels and the optical axis in their middle.
    """

    height_m: float
    tilt_deg: float
    fov_deg: float
    forward_m: float

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
        """Return how far from the camera's foot each pixel sees the floor, (rows, cols); infinite above."""
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

    def outward(self, mask: Bytes, height_m: float) -> Bytes:
        """Return a mask (rows, cols) with every pixel taken from farther from the camera's foot: of lower things."""
        return self.inward(mask, -height_m)

    def inward(self, mask: Bytes, height_m: float, floor_m: float = 0.0) -> Bytes:
        """Return a mask (rows, cols) with every pixel taken nearer to the camera's foot, where vertical lines meet.

        What stands there at the floor covers the pixel with what is ``height_m`` above, or with what is ``floor_m``
        behind it.
        """
        key = (*mask.shape, height_m, floor_m)
        if key not in self._maps:
            self._maps[key] = self._inward_map(*key)
        found: Bytes = cv2.remap(mask, self._maps[key], None, cv2.INTER_NEAREST)
        return found

    @cached_property
    def _maps(self) -> dict[tuple[int, int, float, float], Floats]:
        return {}

    def _inward_map(self, rows: int, cols: int, height_m: float, floor_m: float) -> Floats:
        matrix = self.intrinsics(rows, cols)
        x, y, depth = matrix @ self.R_CR @ [0.0, 0.0, -1.0]
        foot = np.array([x, y]) / depth
        away = np.dstack(np.meshgrid(np.arange(cols), np.arange(rows))) - foot
        length = np.maximum(np.linalg.norm(away, axis=-1, keepdims=True), 1e-6)
        kept = (1.0 - height_m / self.height_m) - floor_m * matrix[0, 0] / self.height_m / length
        return np.asarray(foot + away * np.maximum(kept, 0.0), np.float32)
