"""Mip levels: which texels show a surface without aliasing."""

from __future__ import annotations

import math

import cv2
import numpy as np

from graphnav.arrays import Floats, Indices
from graphnav_world.rendering.atlas import MAX_LEVELS, MIN_LEVELS
from graphnav_world.rendering.camera import Camera
from graphnav_world.rendering.textures import TEXEL_M

STRETCH = 2.0
"""How much longer than wide a pixel's print on a surface may be before the texture is blurred along with it."""


def level_count(camera: Camera) -> int:
    """Return the number of mip levels that prevent aliasing of the floor in this camera."""
    rays = camera.rays()
    depth = camera.height_m / np.maximum(rays @ -camera.R_RC[2], 1e-3)
    long_m = depth**2 * np.square(rays).sum(axis=-1) / (camera.focal_px * camera.height_m * STRETCH)
    needed = math.ceil(math.log2(long_m.max() / TEXEL_M)) + 1
    return min(max(needed, MIN_LEVELS), MAX_LEVELS)


def mip_levels(depth: Floats, length_ratio: Floats, camera: Camera, levels: int) -> tuple[Indices, Floats]:
    """Return the finer of two mip levels and the share of the coarser one, both (pixels,).

    A pixel prints depth / f wide on a surface, and ``length_ratio`` times as long: depth |ray|**2 / distance of the
    plane. Writes to ``length_ratio``.
    """
    print_px = np.maximum(length_ratio, np.float32(STRETCH), out=length_ratio)
    print_px *= depth
    level: Floats = cv2.log(print_px).reshape(-1)
    level *= np.float32(1 / math.log(2))
    level -= np.float32(math.log2(STRETCH * camera.focal_px * TEXEL_M))
    np.maximum(level, np.float32(0), out=level)
    np.minimum(level, np.float32(levels - 1.001), out=level)
    blend, fine = np.modf(level)
    return fine.astype(np.intp), blend
