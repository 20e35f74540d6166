"""The mounting of a camera, with what stands on the floor: masks of it, moved along the lines of sight."""

from __future__ import annotations

from functools import cached_property

import cv2
import numpy as np

from graphnav import Mount
from graphnav.arrays import Bytes, Floats


class MaskMount(Mount):
    """A mounting that moves masks of pixels towards the camera's foot and away from it."""

    def outward(self, mask: Bytes, height_m: float) -> Bytes:
        """Return a mask (rows, cols) of things on the floor with what is below them, down by a height.

        Vertical lines meet in the pixel of the camera's foot: every pixel is taken from farther out.
        """
        return self.inward(mask, -height_m)

    def inward(self, mask: Bytes, height_m: float, floor_m: float = 0.0) -> Bytes:
        """Return a mask (rows, cols) with every pixel taken from nearer to the camera's foot.

        Nearer by what ``height_m`` shifts it, and by ``floor_m`` on the floor below the camera.
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
