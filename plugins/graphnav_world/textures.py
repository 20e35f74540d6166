"""Textures from layered noise: they tile without a seam, each seed gives another one."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

Bytes = npt.NDArray[np.uint8]
Floats = npt.NDArray[np.float32]

TEXEL_M = 0.005
OCTAVE_GAIN = 1.15
"""How much stronger noise of twice the grain is."""
RIM = 7
"""Lattice values around the noise: what blur and interpolation reach for."""


@dataclass(frozen=True)
class Texture:
    """How a surface looks: mean gray and standard deviation, both of 255, and the size of its largest grains."""

    mean: float = 120.0
    contrast: float = 32.0
    grain_m: float = 0.15

    def pixels(self, width: int, height: int, rng: np.random.Generator) -> Bytes:
        """Return gray uint8 (height, width) that tiles: octaves of noise from one texel up to ``grain_m``."""
        total = np.zeros((height, width), np.float32)
        for octave in range(max(1, round(math.log2(self.grain_m / TEXEL_M)) + 1)):
            total += _noise(width, height, 2**octave, rng) * np.float32(OCTAVE_GAIN**octave)
        total -= total.mean()
        total *= np.float32(self.contrast) / total.std()
        total += np.float32(self.mean)
        return np.clip(total, 0, 255, out=total).astype(np.uint8)


def _noise(width: int, height: int, grain: int, rng: np.random.Generator) -> Floats:
    """Return noise with grains of this many texels, (height, width), that tiles and has no preferred direction.

    Drawn and blurred on a lattice of two values a grain, on which it is smooth, then interpolated.
    """
    if grain == 1:
        return rng.standard_normal((height, width), dtype=np.float32)
    rows, cols = math.ceil(2 * height / grain), math.ceil(2 * width / grain)
    lattice = np.pad(rng.standard_normal((rows, cols), dtype=np.float32), RIM, mode="wrap")
    lattice = cv2.GaussianBlur(lattice, (RIM, RIM), 1.0)
    to_lattice = np.array([[cols / width, 0.0, RIM], [0.0, rows / height, RIM]])
    flags = cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP
    fine: Floats = cv2.warpAffine(lattice, to_lattice, (width, height), flags=flags, borderMode=cv2.BORDER_REPLICATE)
    fine /= fine.std()
    return fine
