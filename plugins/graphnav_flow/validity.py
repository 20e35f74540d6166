"""Validity of flow vectors: the common rule of all estimators.

A vector is valid where

- the pixel and its source lie inside the image by a margin: nearer to the border windows extend
  beyond the picture, and new parts of the picture are extrapolated;
- the image has texture there in two directions: the smaller eigenvalue of the windowed mean of the gradient's outer
  product [Shi, Tomasi: Good Features to Track, CVPR 1994] reaches a threshold. Image noise of standard deviation s
  alone gives about s^2 / 2.
"""

from __future__ import annotations

import cv2
import numpy as np

from graphnav.arrays import Bytes, Floats

BLOCK_PX = 4
MARGIN_PX = 6.0
MARGIN_DOC = "vectors from or at places nearer to the border than this are not valid"
MIN_TEXTURE_GRAY2 = 4.0
MIN_TEXTURE_DOC = "minimum of the smaller eigenvalue of the structure tensor for a vector to be valid"


def came_from_inside(uv_px: Floats, margin_px: float) -> Bytes:
    """Return 1 where a pixel and its source lie inside the image by ``margin_px``, uint8 (rows, cols).

    ``uv_px``: float32 (rows, cols, 2), displacement since the last frame of what is now at the pixel.
    """
    rows, cols = uv_px.shape[:2]
    x = np.arange(cols, dtype=np.float32) - uv_px[..., 0]
    y = np.arange(rows, dtype=np.float32)[:, None] - uv_px[..., 1]
    valid: Bytes = cv2.inRange(x, margin_px, cols - 1 - margin_px)
    valid &= cv2.inRange(y, margin_px, rows - 1 - margin_px)
    valid &= 1
    border = int(np.ceil(margin_px))
    if border:
        valid[:border] = valid[-border:] = valid[:, :border] = valid[:, -border:] = 0
    return valid


def min_eigenvalue(uu: Floats, uv: Floats, vv: Floats) -> Floats:
    """Return the smaller eigenvalue of the symmetric matrices [[uu, uv], [uv, vv]], float32 (rows, cols)."""
    smaller: Floats = (uu + vv - cv2.magnitude(uu - vv, 2 * uv)) / 2
    return smaller


def texture(gray: Bytes) -> Floats:
    """Return the smaller eigenvalue of the structure tensor of ``gray``, (gray / px)^2, float32 (rows, cols).

    Averaged over 3x3 blocks of 4x4 pixels, a fifth of the cost of a window around every pixel.
    """
    gu = cv2.Sobel(gray, cv2.CV_16S, 1, 0, ksize=1)
    gv = cv2.Sobel(gray, cv2.CV_16S, 0, 1, ksize=1)
    rows, cols = gray.shape
    blocks = (max(1, cols // BLOCK_PX), max(1, rows // BLOCK_PX))
    products = (cv2.multiply(one, other, scale=0.25, dtype=cv2.CV_32F) for one, other in ((gu, gu), (gu, gv), (gv, gv)))
    uu, uv, vv = (cv2.blur(cv2.resize(p, blocks, interpolation=cv2.INTER_AREA), (3, 3)) for p in products)
    fine: Floats = cv2.resize(min_eigenvalue(uu, uv, vv), (cols, rows))
    return fine


def trusted(uv_px: Floats, gray: Bytes, margin_px: float, min_texture_gray2: float) -> Bytes:
    """Return 1 where a vector on the image ``gray`` is valid by both parts of the rule, uint8 (rows, cols)."""
    inside = came_from_inside(uv_px, margin_px)
    inside &= texture(gray) >= min_texture_gray2
    return inside
