"""The film of a camera: blur, brightness, noise, white and compression make a picture of gray values."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from statistics import NormalDist

import cv2
import numpy as np

from graphnav.arrays import Bytes, Floats

NOISE_BITS = 12
NOISE_STEPS = 2**NOISE_BITS
"""The values that noise has."""
_QUANTILES: Floats = np.array([NormalDist().inv_cdf((k + 0.5) / NOISE_STEPS) for k in range(NOISE_STEPS)], np.float32)
DISC_SAMPLES = 16
"""Samples along each side of a pixel by which its share of a disc is found."""


@dataclass(frozen=True)
class Film:
    """Steps that make a picture of gray values, in this order.

    ``defocus_px``: radius of the disc into which the lens spreads a point. ``light``: brightness. ``noise_sigma_gray``:
    of the noise that ``rng`` draws. White is at 255. ``jpeg_quality``: of a compression that loses detail, or None.
    """

    light: float = 1.0
    noise_sigma_gray: float = 0.0
    rng: np.random.Generator | None = None
    defocus_px: float = 0.0
    jpeg_quality: int | None = None

    def blurred(self, gray: Floats) -> Floats:
        """Return gray values, float32 (rows, cols), out of focus; beyond the edge the picture is its mirror image."""
        if not self.defocus_px:
            return gray
        blurred: Floats = cv2.filter2D(gray, cv2.CV_32F, disc(self.defocus_px), borderType=cv2.BORDER_REFLECT_101)
        return blurred

    def exposed(self, gray: Floats, views: int = 1) -> Bytes:
        """Return the picture, uint8, of the sum of the gray values of so many views."""
        noise, sigma = gray, 0.0
        if self.noise_sigma_gray and self.rng is not None:
            noise, sigma = normal_noise(gray.shape, self.rng), self.noise_sigma_gray
        pixels: Bytes = cv2.addWeighted(gray, self.light / views, noise, sigma, 0.0, dtype=cv2.CV_8U)
        return pixels

    def compressed(self, pixels: Bytes) -> Bytes:
        """Return a picture, uint8, as it is after JPEG's compression."""
        if self.jpeg_quality is None:
            return pixels
        _, encoded = cv2.imencode(".jpg", pixels, (cv2.IMWRITE_JPEG_QUALITY, self.jpeg_quality))
        return np.asarray(cv2.imdecode(encoded, cv2.IMREAD_GRAYSCALE), np.uint8)


@lru_cache(maxsize=4)
def disc(radius_px: float) -> Floats:
    """Return a disc of sum 1, float32 (side, side), an odd number: each pixel has the share of it that it covers."""
    half = math.ceil(radius_px - 0.5)
    side = 2 * half + 1
    place = (np.arange(side * DISC_SAMPLES) + 0.5) / DISC_SAMPLES - side / 2
    inside = np.hypot(place[:, None], place) <= radius_px
    share = inside.reshape(side, DISC_SAMPLES, side, DISC_SAMPLES).sum(axis=(1, 3))
    kernel: Floats = (share / share.sum()).astype(np.float32)
    kernel.setflags(write=False)
    return kernel


def normal_noise(shape: tuple[int, ...], rng: np.random.Generator) -> Floats:
    """Return Gaussian noise of sigma 1, float32, cut to 4096 quantiles: a tenth of the cost of exact draws.

    Each value takes the high bits of 16 random ones.
    """
    size = math.prod(shape)
    if size % 4 == 0:
        words = rng.bit_generator.random_raw(size // 4)
    else:  # the same bits, from words of which none is drawn in part
        words = rng.integers(0xFFFFFFFF, size=(size + 1) // 2, dtype=np.uint32, endpoint=True)
    draws = words.view(np.uint16)[:size] >> (16 - NOISE_BITS)
    return _QUANTILES.take(draws.astype(np.intp)).reshape(shape)
