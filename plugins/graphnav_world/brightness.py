"""Brightness of the picture over time: a light that swings, steps of the exposure, and a camera that adapts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from graphnav.arrays import Bytes

DARKEST_GRAY = 1.0
"""A picture counts as no darker, so that the gain stays finite."""


@dataclass(frozen=True)
class Swing:
    """A light that rises and falls as a sine."""

    ratio: float
    period_s: float

    def at(self, time_s: float) -> float:
        """Return the factor of the brightness."""
        return 1 + self.ratio * math.sin(2 * math.pi * time_s / self.period_s)


class ExposureSteps:
    """Jumps of a camera's automatic exposure.

    Every ``0.5 to 1.5 * every_s`` the factor of the brightness is drawn from 1 / (1 + ratio) to 1 + ratio, uniformly in
    its logarithm; it is one until the first step. ``rng`` draws nothing with a ratio of zero.
    """

    def __init__(self, ratio: float, every_s: float, rng: np.random.Generator) -> None:
        self._largest = math.log1p(ratio)
        self._every_s, self._rng = every_s, rng
        self._factor = 1.0
        self._next_s = self._drawn_s() if ratio else math.inf

    def at(self, time_s: float) -> float:
        """Return the factor of the brightness; times must not decrease."""
        while self._next_s <= time_s:
            self._factor = math.exp(self._rng.uniform(-self._largest, self._largest))
            self._next_s += self._drawn_s()
        return self._factor

    def _drawn_s(self) -> float:
        return self._every_s * self._rng.uniform(0.5, 1.5)


class AutoExposure:
    """A camera's gain, by which the mean of its pictures approaches a gray value.

    The error of the gain's logarithm falls as exp(-t / settle_s). It is measured in the picture made, so that what is
    white already hides how much too bright it is; a frame's gain follows from the frame before. ``bounds``: smallest
    and largest gain.
    """

    def __init__(self, gray: float, settle_s: float, bounds: tuple[float, float]) -> None:
        self._gray, self._settle_s, self._bounds = gray, settle_s, bounds
        self._gain: float | None = None
        self._time_s = 0.0
        self._mean_gray = gray

    def at(self, time_s: float, unit_gray: float) -> float:
        """Return the gain; ``unit_gray``: mean of this picture with a gain of one, for which it starts settled."""
        if self._gain is None:
            wanted = self._gray / max(unit_gray, DARKEST_GRAY)
        else:
            share = 1 - math.exp((self._time_s - time_s) / self._settle_s)
            wanted = self._gain * (self._gray / max(self._mean_gray, DARKEST_GRAY)) ** share
        low, high = self._bounds
        self._gain, self._time_s = min(max(wanted, low), high), time_s
        return self._gain

    def see(self, pixels: Bytes) -> None:
        """Measure the picture made with the last gain."""
        self._mean_gray = cv2.mean(pixels)[0]
