"""Texture atlas: all textures of a world with all their mip levels in one picture."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np

from graphnav.arrays import Bytes, Floats
from graphnav_world.rendering.textures import BLOCK, TEXEL_M, Texture, wrapped

MIN_LEVELS, MAX_LEVELS = 6, 8
"""Mip levels: texels of 0.16 m are coarse enough for what lies within 6 m, those of 0.64 m up to the horizon."""
PAD = 2
LARGEST_TEXELS = 3072
BODY_TEXELS = (2048, 512)


def floor_texels(extent_m: Sequence[float]) -> tuple[int, int]:
    """Return the size (width, height) of a floor texture that covers a world of this size, at most 15 m."""
    width, height = (min(LARGEST_TEXELS, math.ceil(m / TEXEL_M / BLOCK) * BLOCK) for m in extent_m)
    return width, height


class Atlas:
    """Mip-mapped textures side by side in one uint8 picture, each of ``levels`` with a wrapped border.

    Texture k at level l has texels of 5 mm times 2**l; the texture coordinate (u, v), in metres and within
    ``period_m[k]``, lies at pixel (u, v) / ``texel_m[l]`` + ``origin_px[k, l]``. The first texture is the floor's.
    """

    def __init__(
        self,
        textures: Sequence[Texture],
        floor_size: tuple[int, int],
        rng: np.random.Generator,
        levels: int = MIN_LEVELS,
    ) -> None:
        self.levels = levels
        sizes = [floor_size] + [BODY_TEXELS] * (len(textures) - 1)
        heights = [height + levels * 2 * PAD for _, height in sizes]
        width = max(w + (w // 2) for w, _ in sizes) + 4 * PAD
        self.pixels: Bytes = np.zeros((sum(heights), width), np.uint8)
        self.texel_m = (TEXEL_M * 2.0 ** np.arange(levels)).astype(np.float32)
        self.period_m = np.array(sizes, np.float32) * np.float32(TEXEL_M)
        self.origin_px: Floats = np.zeros((len(textures), levels, 2), np.float32)
        top = 0
        for k, (texture, size) in enumerate(zip(textures, sizes, strict=True)):
            self._place(k, top, texture.pixels(*size, rng))
            top += heights[k]

    def texels(self, k: int) -> Bytes:
        """Return texture k at the finest level, uint8 (height, width), without border; its first row has v = 0."""
        width, height = np.rint(self.period_m[k] / TEXEL_M).astype(int).tolist()
        left, top = np.rint(self.origin_px[k, 0] + 0.5).astype(int).tolist()
        return self.pixels[top : top + height, left : left + width]

    def _place(self, k: int, top: int, texels: Bytes) -> None:
        left, below = 0, top
        for level in range(self.levels):
            padded = wrapped(texels, PAD)
            height, width = padded.shape
            self.pixels[below : below + height, left : left + width] = padded
            self.origin_px[k, level] = left + PAD - 0.5, below + PAD - 0.5
            left, below = (width, top) if level == 0 else (left, below + height)
            texels = cv2.resize(texels, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
