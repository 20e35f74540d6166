"""Soft shadows in the sun: of objects out of view, fixed in the world, and of the robot."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from graphnav.arrays import Doubles, Floats
from graphnav_world.geometry.scene import SUN_W
from graphnav_world.rendering.placed_faces import Placed
from graphnav_world.rendering.visibility import Visible

TEXEL_M, TEXELS = 0.02, 1024
"""The pattern repeats after 20 m."""
BLOB_M, PENUMBRA_M = 0.35, 0.05
"""Standard deviation of the blur that makes the pattern, and half the width of soft edges."""
SHARP_M, BLURRED_M = 0.1, 0.7
"""A pattern is drawn as it is where a pixel is no longer than this on the floor, and as its mean where it is longer."""
FALL_M: Doubles = -SUN_W[:2] / SUN_W[2]
"""Length of a shadow per metre of height."""


class Caster(NamedTuple):
    """The robot as it casts a shadow: an upright cylinder as high as its camera at rest."""

    radius_m: float
    height_m: float


class Shadows:
    """Shadows of parallel sunlight, with soft edges, as a share from 0 (sunlit) to 1.

    Objects out of view shade about half of the floor in irregular patches of about a metre; ``rng`` draws them. What
    stands on the floor lies in the same shadows, along the sun's rays; it casts none itself. Towards the horizon the
    patches blend into their mean.
    """

    def __init__(self, robot: Caster, focal_px: float, rng: np.random.Generator) -> None:
        self._robot, self._focal_px = robot, focal_px
        blob_px = BLOB_M / TEXEL_M
        white = np.pad(rng.standard_normal((TEXELS, TEXELS), np.float32), margin := round(4 * blob_px), mode="wrap")
        field: Floats = cv2.GaussianBlur(white, (0, 0), blob_px)[margin:-margin, margin:-margin]
        field /= field.std()
        slope_per_m = 1 / (BLOB_M * np.sqrt(2))
        soft = 0.5 + field / (2 * PENUMBRA_M * slope_per_m)
        self._pattern: Floats = np.pad(np.clip(soft, 0.0, 1.0), (0, 1), mode="wrap")

    def at(self, now: Placed, seen: Visible, rays: Floats, inverse_depth: Floats) -> Floats:
        """Return the shadow at every pixel's surface point, float32 (rows, cols), 0 on faces turned from the sun.

        ``rays``: in C, (rows, cols, 3).
        """
        depth = np.reciprocal(np.maximum(inverse_depth, np.float32(1e-3)))
        points = cv2.transform(rays, now.R_WC) * depth[..., None] + now.eye_W.astype(np.float32)
        height_m = np.maximum(points[..., 2], 0.0)
        fallen = points[..., :2] + height_m[..., None] * FALL_M.astype(np.float32)
        print_m = depth**2 * np.square(rays).sum(axis=-1) / np.float32(self._focal_px * now.eye_W[2])
        shadow = np.maximum(self._of_others(fallen, print_m), self._of_robot(fallen, height_m, now.eye_W))
        turned_away = now.faces.normal @ SUN_W <= 0
        shadow.reshape(-1)[seen.pixel] *= ~turned_away.take(seen.pixel_face)
        return shadow

    def _of_others(self, fallen: Floats, print_m: Floats) -> Floats:
        """Return the pattern's shadow; ``print_m``: the length of each pixel on the floor."""
        place = fallen / np.float32(TEXEL_M) % np.float32(TEXELS)
        shadow: Floats = cv2.remap(self._pattern, place, None, cv2.INTER_LINEAR)
        shadow -= 0.5
        shadow *= np.clip((BLURRED_M - print_m) / (BLURRED_M - SHARP_M), 0.0, 1.0)
        shadow += 0.5
        return shadow

    def _of_robot(self, fallen: Floats, height_m: Floats, eye_W: Doubles) -> Floats:
        """Return the shadow of an upright cylinder at points by where their sun rays meet the floor."""
        x, y = np.moveaxis(fallen - eye_W[:2].astype(np.float32), -1, 0)
        fall_x, fall_y = (FALL_M * self._robot.height_m).tolist()
        share = (x * fall_x + y * fall_y) / (fall_x**2 + fall_y**2)
        share = np.clip(share, np.minimum(height_m / self._robot.height_m, 1.0), 1.0)
        away_m = np.hypot(x - share * fall_x, y - share * fall_y)
        soft = 0.5 + (self._robot.radius_m - away_m) / (2 * PENUMBRA_M)
        shadow: Floats = np.clip(soft, 0.0, 1.0).astype(np.float32)
        return shadow * (height_m < self._robot.height_m)
