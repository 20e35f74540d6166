"""Image pyramids: what Lucas-Kanade compares between two frames."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
import numpy.typing as npt

Plane32 = npt.NDArray[np.float32]

LEAST_SIDE_PX = 8
"""A layer is not halved where its shorter side would fall below this: no window fits."""


class Pyramid(NamedTuple):
    """One frame at several sizes.

    ``layers``: float32 (rows, cols), the base first, each half as large as the one before; pixel i of a layer lies on
    pixel 2i of the one before. ``doubled``: the base at twice its size (cubic). Sampling it bilinearly is nearly as
    exact as sampling the base with a cubic kernel, at a fifth of the time.
    """

    layers: tuple[Plane32, ...]
    doubled: Plane32


def build_pyramid(gray: npt.NDArray[np.uint8], layers: int) -> Pyramid:
    """Return ``gray`` with up to ``layers`` smaller copies above it."""
    base = gray.astype(np.float32)
    built = [base]
    while len(built) <= layers and min(built[-1].shape) >= 2 * LEAST_SIDE_PX:
        built.append(cv2.pyrDown(built[-1]))
    rows, cols = base.shape
    doubled = cv2.resize(base, (2 * cols, 2 * rows), interpolation=cv2.INTER_CUBIC)
    return Pyramid(tuple(built), doubled)
