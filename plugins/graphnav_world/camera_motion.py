"""Camera shake: pitch, roll and height of a camera whose mast sways and whose robot bounces."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from graphnav_world.rendering.camera import Camera

FARTHEST_SIGMAS = 3.0
"""Textures are made for tilts and heights up to so many standard deviations from those at rest."""


@dataclass(frozen=True)
class Shake:
    """How much a camera moves on its mast: standard deviations, and the time constant of the correlation."""

    sigma_deg: float
    height_ratio: float
    correlation_s: float

    def __bool__(self) -> bool:
        """Whether the camera moves at all."""
        return bool(self.sigma_deg or self.height_ratio)

    def farthest(self, camera: Camera) -> Camera:
        """Return the camera where it sees farthest."""
        tilt_deg = camera.tilt_deg - FARTHEST_SIGMAS * self.sigma_deg
        height_m = camera.height_m * (1 + FARTHEST_SIGMAS * self.height_ratio)
        return replace(camera, tilt_deg=tilt_deg, height_m=height_m)


class CameraMotion:
    """Pitch, roll and height as independent, stationary Ornstein-Uhlenbeck processes (first-order Gauss-Markov).

    The autocorrelation after a time t is exp(-t / correlation_s), whatever the times between frames: each step is
    exact (D. T. Gillespie, Exact numerical simulation of the Ornstein-Uhlenbeck process, Phys. Rev. E 54, 1996).
    ``rng`` draws nothing for a camera that does not move.
    """

    def __init__(self, camera: Camera, shake: Shake, rng: np.random.Generator) -> None:
        self._camera, self._shake, self._rng = camera, shake, rng
        self._time_s = -math.inf
        self._now = np.zeros(3)

    def at(self, time_s: float) -> Camera:
        """Return the camera at a time, seconds; times must not decrease."""
        if not self._shake:
            return self._camera
        keep = math.exp((self._time_s - time_s) / self._shake.correlation_s)
        new = math.sqrt(1 - keep * keep)
        self._time_s = time_s
        self._now = keep * self._now + new * self._rng.standard_normal(3)
        pitch, roll, height = self._now.tolist()
        return replace(
            self._camera,
            tilt_deg=self._camera.tilt_deg + pitch * self._shake.sigma_deg,
            roll_deg=self._camera.roll_deg + roll * self._shake.sigma_deg,
            height_m=self._camera.height_m * (1 + height * self._shake.height_ratio),
        )
