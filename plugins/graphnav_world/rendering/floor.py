"""The floor in the picture: its texture at every pixel, as if there were no bodies."""

from __future__ import annotations

import cv2
import numpy as np

from graphnav.arrays import Doubles, Floats
from graphnav_world.rendering.atlas import Atlas
from graphnav_world.rendering.camera import Camera
from graphnav_world.rendering.mip import mip_levels
from graphnav_world.rendering.placed_faces import Placed

SKY_GRAY = 255


class Floor:
    """Draws the floor; ``origin_m``: the world point where its texture begins.

    ``inverse_depth``: float32 (rows, cols), 1/m along the optical axis, 0 above the horizon.
    """

    def __init__(self, camera: Camera, atlas: Atlas, origin_m: Doubles) -> None:
        self._atlas, self._origin_m = atlas, origin_m
        rays_R = camera.rays() @ camera.R_RC.T
        inverse = np.maximum(-rays_R[..., 2] / camera.height_m, 0.0).astype(np.float32)
        self.inverse_depth: Floats = inverse
        self._sky = np.flatnonzero(inverse <= 0)
        depth = np.reciprocal(np.maximum(inverse, np.float32(1e-3)))
        self._place_R: Floats = np.ascontiguousarray(rays_R[..., :2].astype(np.float32) * depth[..., None])
        self._reach_m = float(np.linalg.norm(self._place_R, axis=-1).max())
        length_ratio = depth * np.square(rays_R).sum(axis=-1).astype(np.float32) / np.float32(camera.height_m)
        level, blend = mip_levels(depth.reshape(-1), length_ratio.reshape(-1), camera, atlas.levels)
        self._blend = blend.reshape(inverse.shape)
        shape = self._place_R.shape
        self._per_m = np.repeat(1 / atlas.texel_m[level], 2).reshape(shape)
        self._fine_px, coarse = (atlas.origin_px[0, one].reshape(shape) for one in (level, level + 1))
        self._coarse_px: Floats = coarse - self._fine_px * np.float32(0.5)

    def gray(self, now: Placed) -> Floats:
        """Return the gray values before light and noise, float32 (rows, cols)."""
        fine_px, coarse_px = self._places(now)
        fine = cv2.remap(self._atlas.pixels, fine_px, None, cv2.INTER_LINEAR)
        coarse = cv2.remap(self._atlas.pixels, coarse_px, None, cv2.INTER_LINEAR)
        gray: Floats = cv2.subtract(coarse, fine, dtype=cv2.CV_32F)
        gray *= self._blend
        gray += fine
        if len(self._sky):
            gray.reshape(-1)[self._sky] = SKY_GRAY
        return gray

    def _places(self, now: Placed) -> tuple[Floats, Floats]:
        """Return the atlas position of every pixel's floor point, (rows, cols, 2), on the finer and coarser level."""
        c, s = now.heading
        period = self._atlas.period_m[0]
        x, y = (now.eye_W[:2] - self._origin_m) % period
        place: Floats = cv2.transform(self._place_R, np.array([[c, -s, x], [s, c, y]]))
        if min(x, y) < self._reach_m or x + self._reach_m > period[0] or y + self._reach_m > period[1]:
            place -= np.floor(place / period) * period
        place *= self._per_m
        place += self._fine_px
        coarse = place * np.float32(0.5)
        coarse += self._coarse_px
        return place, coarse
