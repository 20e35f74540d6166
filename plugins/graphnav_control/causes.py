"""Causes that forbid the robot to move: missing, old or faulty inputs, and blind views."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import cv2
import numpy as np

from graphnav import Image, Latest, Plane

_BLOCKS = (16, 12)
"""Columns and rows of the blocks over which an image is averaged, to suppress pixel noise."""


class Cause(NamedTuple):
    """An entry of `graphnav.GuardState`: the cause, the guard's input port, the value and its limit."""

    name: str
    port: str
    value: float = 0.0
    limit: float = 0.0


def lost(port: str, input: Latest[Any], max_age_s: float, waited_s: float) -> list[Cause]:  # noqa: A002
    """Return the causes of an unreliable input: "waiting", "stale", "fault"; none if it is not wired.

    ``waited_s``: time since the guard started, which is the value of "waiting".
    """
    if not input.is_connected:
        return []
    if input.value is None or not math.isfinite(input.age_s):
        return [Cause("waiting", port, waited_s, max_age_s)]
    causes = []
    if input.age_s > max_age_s:
        causes.append(Cause("stale", port, input.age_s, max_age_s))
    if input.fault or input.value.not_finite():
        causes.append(Cause("fault", port))
    return causes


def judged_ratio(plane: Plane) -> float:
    """Return the share of the plane's cells that were judged."""
    return int(np.count_nonzero(plane.valid)) / max(plane.valid.size, 1)


def contrast(image: Image) -> float:
    """Return the standard deviation of the image's gray levels, averaged over 16 x 12 blocks.

    Blocks, because the noise of a covered lens has contrast between pixels, but hardly any between blocks.
    """
    blocks = cv2.resize(image.pixels, _BLOCKS, interpolation=cv2.INTER_AREA)
    gray = blocks if blocks.ndim == 2 else blocks.mean(axis=-1)
    return float(cv2.meanStdDev(gray)[1][0, 0])
