"""Textures from layered noise that tile without a seam, different for each seed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeVar

import cv2
import numpy as np

from graphnav.arrays import Bytes, Floats

TEXEL_M = 0.005
LARGEST_GRAIN = 7
"""As a power of two, in texels."""
BLOCK = 2**LARGEST_GRAIN
"""Widths and heights of textures, in texels, are multiples of this."""
OCTAVE_GAIN = 1.15
"""Amplitude ratio of noise of twice the grain."""
RIM = 4
"""Border of a texture for blur and interpolation, in texels."""
Tiled = TypeVar("Tiled", Bytes, Floats)
BLUR_PX, BLUR_GAIN = 1.0, 3.545
"""Blur that makes noise of two texels' grain, and what restores its standard deviation (2 sqrt(pi) sigma)."""


@dataclass(frozen=True)
class Texture:
    """Appearance of a surface: mean gray and standard deviation, both of 255, and the size of its largest grains.

    Grains of more than 0.64 m count as 0.64 m. With ``tile_m`` it repeats: square tiles of that side, all alike, with
    joints of the gray ``joint``, ``joint_m`` wide, between them; mean and contrast are then those of a tile's face.
    """

    mean: float = 120.0
    contrast: float = 32.0
    grain_m: float = 0.15
    tile_m: float | None = None
    joint_m: float = 0.01
    joint: float = 60.0

    def pixels(self, width: int, height: int, rng: np.random.Generator) -> Bytes:
        """Return gray uint8 (height, width) that tiles: octaves of noise from one texel up to ``grain_m``.

        Built from coarse to fine: each level is the coarser one enlarged, plus noise of two texels' grain.
        """
        octaves = min(max(1, round(math.log2(self.grain_m / TEXEL_M))), LARGEST_GRAIN)
        total = np.zeros((height >> octaves, width >> octaves), np.float32)
        for level in reversed(range(octaves)):
            total = _enlarged(total)
            white = rng.random(total.shape, dtype=np.float32)
            white -= np.float32(0.5)
            grains = cv2.GaussianBlur(wrapped(white, RIM), (0, 0), BLUR_PX)[RIM:-RIM, RIM:-RIM]
            cv2.scaleAdd(grains, BLUR_GAIN * OCTAVE_GAIN ** (level + 1), total, total)
        total += white
        if self.tile_m is not None:
            side = _texels(self.tile_m)
            total = total[:side, :side]
        total -= total.mean()
        total *= np.float32(self.contrast) / total.std()
        total += np.float32(self.mean)
        if self.tile_m is not None:
            total = self._laid(total, width, height)
        return np.clip(total, 0, 255, out=total).astype(np.uint8)

    def _laid(self, face: Floats, width: int, height: int) -> Floats:
        """Return tiles of this ``face`` and their joints, (height, width); the last ones may be cut."""
        joint = _texels(self.joint_m)
        face[:joint] = face[:, :joint] = self.joint
        rows, cols = face.shape
        return np.tile(face, (-(-height // rows), -(-width // cols)))[:height, :width]


def wrapped(field: Tiled, rim: int) -> Tiled:
    """Return a field that tiles with a border of ``rim`` texels, which goes on as the field begins."""
    wider: Tiled = cv2.copyMakeBorder(field, rim, rim, rim, rim, cv2.BORDER_WRAP)
    return wider


def _texels(length_m: float) -> int:
    return max(round(length_m / TEXEL_M), 1)


def _enlarged(field: Floats) -> Floats:
    """Return a field that tiles at twice the size."""
    padded = wrapped(field, RIM)
    twice: Floats = cv2.resize(padded, None, fx=2, fy=2, interpolation=cv2.INTER_CUBIC)
    return twice[2 * RIM : -2 * RIM, 2 * RIM : -2 * RIM].copy()
