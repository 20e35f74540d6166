"""Optical flow as colours: direction is hue, length is saturation."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from graphnav.arrays import Bools, Bytes

INVALID = 190
"""Gray level of pixels without flow."""


def flow_scale_px(uv_px: npt.NDArray[Any], valid: npt.NDArray[Any]) -> float:
    """Return the length drawn in full colour: the 98th percentile of valid vectors, at least 0.1 px."""
    seen = uv_px[valid != 0]
    if not len(seen):
        return 0.1
    return max(float(np.percentile(np.hypot(seen[:, 0], seen[:, 1]), 98)), 0.1)


def flow_rgb(uv_px: npt.NDArray[Any], valid: npt.NDArray[Any], full_px: float) -> Bytes:
    """Return (rows, cols, 3) red-green-blue: white for no motion, full colour from ``full_px``.

    Right is red, down yellow-green, left cyan, up violet; gray where there is no flow.
    """
    u, v = np.asarray(uv_px[..., 0], np.float32), np.asarray(uv_px[..., 1], np.float32)
    length, angle = cv2.cartToPolar(u, v, angleInDegrees=True)
    hsv = np.empty((*u.shape, 3), np.uint8)
    hsv[..., 0] = (angle / 2).astype(np.uint8) % 180
    hsv[..., 1] = np.clip(length * (255 / full_px), 0, 255).astype(np.uint8)
    hsv[..., 2] = 255 - (hsv[..., 1] // 8)
    rgb: Bytes = cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB)
    rgb[np.asarray(valid) == 0] = INVALID
    return rgb


def wheel_rgb(size_px: int) -> tuple[Bytes, Bools]:
    """Return the legend, a disc (size, size, 3) whose rim is full colour, and where the disc is."""
    axis = np.linspace(-1.0, 1.0, size_px, dtype=np.float32)
    x, y = np.meshgrid(axis, axis)
    disc = np.hypot(x, y) <= 1.0
    return flow_rgb(np.stack([x, y], axis=-1), np.ones_like(x), 1.0), disc
