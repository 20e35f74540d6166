"""Validity of flow vectors: the common rule of all estimators.

A vector is valid where

- the pixel and its source lie inside the image by a margin: nearer to the border windows extend
  beyond the picture, and new parts of the picture are extrapolated;
- the image has texture there in two directions: the smaller eigenvalue of the windowed mean of the gradient's outer
  product [Shi, Tomasi: Good Features to Track, CVPR 1994] reaches a threshold. Image noise of standard deviation s
  alone gives about s^2 / 2.
"""

from __future__ import annotations

import math

import cv2
import numpy as np

from graphnav.arrays import Bools, Bytes, Floats
from graphnav_flow.texture import Texture

MARGIN_PX = 6.0
MARGIN_DOC = "vectors from or at places nearer to the border than this are not valid"
MIN_TEXTURE_GRAY2 = 4.0
MIN_TEXTURE_DOC = "minimum of the smaller eigenvalue of the structure tensor for a vector to be valid"


class Validity:
    """Applies the rule to the flow on images of one size."""

    def __init__(self, margin_px: float, min_texture_gray2: float) -> None:
        self._margin_px, self._min_texture_gray2 = margin_px, min_texture_gray2
        self._texture: Texture | None = None

    def mark(self, uv_px: Floats, gray: Bytes) -> Bytes:
        """Return 1 where a vector on the image ``gray`` is valid by both parts of the rule, uint8 (rows, cols)."""
        if self._texture is None:
            self._texture = Texture(*gray.shape)
        valid = self._texture.reaches(gray, self._min_texture_gray2)
        clear_outside(valid, uv_px, self._margin_px)
        return valid.view(np.uint8)


def came_from_inside(uv_px: Floats, margin_px: float) -> Bytes:
    """Return 1 where a pixel and its source lie inside the image by ``margin_px``, uint8 (rows, cols).

    ``uv_px``: float32 (rows, cols, 2), displacement since the last frame of what is now at the pixel.
    """
    valid = np.ones(uv_px.shape[:2], bool)
    clear_outside(valid, uv_px, margin_px)
    return valid.view(np.uint8)


def clear_outside(valid: Bools, uv_px: Floats, margin_px: float) -> None:
    """Clear ``valid``, (rows, cols), where a pixel or its source is nearer than ``margin_px`` to the border."""
    lowest, highest, _, _ = cv2.minMaxLoc(uv_px.reshape(len(uv_px), -1))
    longest_px = max(highest, -lowest)
    border = math.ceil(margin_px)
    for lines, shifts in ((valid.T, uv_px[..., 0].T), (valid, uv_px[..., 1])):
        count = len(lines)
        # What is farther inside than the longest vector cannot come from outside.
        reach = min(count, math.ceil(margin_px + longest_px) + 1)
        place = np.arange(count, dtype=np.float32)[:, None]
        lines[:reach] &= shifts[:reach] <= place[:reach] - margin_px
        lines[-reach:] &= shifts[-reach:] >= place[-reach:] - (count - 1 - margin_px)
        if border:
            lines[:border] = lines[-border:] = False
