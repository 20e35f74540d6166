"""Causes that restrict the robot: missing, old or faulty inputs, blind views, inputs that do not follow its motion."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import cv2
import numpy as np

from graphnav import Image, Latest, Plane

_RESUME_RATIO = 0.8
_RESUME_PERIODS = 20.0
_BLOCKS = (16, 12)
"""Columns and rows of the blocks over which an image is averaged, to suppress pixel noise."""


class Cause(NamedTuple):
    """An entry of `graphnav.GuardState`: the cause, the guard's input port, the value and its limit.

    ``is_retried``: the robot drives slowly to see whether the cause is gone; otherwise it may not go forward.
    """

    name: str
    port: str
    value: float = 0.0
    limit: float = 0.0
    is_retried: bool = False


class Staleness:
    """Whether an input is too old, with hysteresis: an age near the limit must not make the robot jerk.

    Stale from an age above ``max_age_s`` on, until every age within ``max_age_s`` was at most 0.8 of it. An input whose
    ages are always between the two, such as a slow camera's, recovers after 20 ``max_age_s`` without a stale one.
    """

    def __init__(self) -> None:
        self._is_stale = False
        self._over_s = self._near_s = self._near_age_s = -math.inf

    def causes(self, port: str, age_s: float, max_age_s: float, now_s: float) -> list[Cause]:
        """Return the cause "stale" if it holds at ``now_s``, seconds that never decrease; at most one."""
        low_s = _RESUME_RATIO * max_age_s
        if age_s > low_s:
            self._near_s, self._near_age_s = now_s, age_s
        if age_s > max_age_s:
            self._is_stale, self._over_s = True, now_s
            return [Cause("stale", port, age_s, max_age_s)]
        if now_s - self._near_s > max_age_s or now_s - self._over_s > _RESUME_PERIODS * max_age_s:
            self._is_stale = False
        return [Cause("stale", port, self._near_age_s, low_s)] if self._is_stale else []


def lost(
    port: str,
    input: Latest[Any],  # noqa: A002
    staleness: Staleness,
    max_age_s: float,
    waited_s: float,
) -> list[Cause]:
    """Return the causes of an unreliable input: "waiting", "stale", "fault"; none if it is not wired.

    ``waited_s``: time since the guard started, which is the value of "waiting".
    """
    if not input.is_connected:
        return []
    if input.value is None or not math.isfinite(input.age_s):
        return [Cause("waiting", port, waited_s, max_age_s)]
    causes = staleness.causes(port, input.age_s, max_age_s, waited_s)
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
