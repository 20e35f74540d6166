"""Image pyramids for Lucas-Kanade."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from graphnav.arrays import Bytes, Floats

MIN_SIDE_PX = 8
"""A layer is not halved if its shorter side would fall below this: no window fits."""


_HALFWAY = np.array([3, -25, 150, 150, -25, 3], np.float32) / np.float32(256)
"""Interpolates half way between two pixels: exact for polynomials up to the fifth degree."""


class Pyramid(NamedTuple):
    """One frame at several sizes.

    ``layers``: float32 (rows, cols), the base first, each half as large as the one before; pixel i of a layer lies on
    pixel 2i of the one before. ``doubled``: the base with one value between any two, float32 (2 rows - 1, 2 cols - 1);
    pixel i of the base is its pixel 2i. Sampling it bilinearly is nearly as exact as sampling the base with a long
    kernel, at a fifth of the time.
    """

    layers: tuple[Floats, ...]
    doubled: Floats


def build_pyramid(gray: Bytes, layers: int) -> Pyramid:
    """Return ``gray`` with up to ``layers`` smaller copies above it."""
    built: list[Floats] = [gray.astype(np.float32)]
    while len(built) <= layers and min(built[-1].shape) >= 2 * MIN_SIDE_PX:
        built.append(cv2.pyrDown(built[-1]))
    return Pyramid(tuple(built), _double(built[0]))


def _double(base: Floats) -> Floats:
    rows, cols = base.shape
    before = len(_HALFWAY) // 2 - 1
    right = cv2.filter2D(base, -1, _HALFWAY[None], anchor=(before, 0))
    wide = cv2.merge([base, right]).reshape(rows, 2 * cols)
    below = cv2.filter2D(wide, -1, _HALFWAY[:, None], anchor=(0, before))
    doubled: Floats = np.stack([wide, below], axis=1).reshape(2 * rows, 2 * cols)
    return doubled[: 2 * rows - 1, : 2 * cols - 1]
