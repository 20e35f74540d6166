"""Brightness of the picture over time: a light that swings, and steps of the exposure."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np


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
