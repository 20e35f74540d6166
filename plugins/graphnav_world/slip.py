"""Wheels that slip on the floor."""

from __future__ import annotations

import math

import numpy as np

HEADINGS = 2
"""The wheels' motion forwards and their turn, which slip independently of each other."""


class Slip:
    """Reduces the motion of wheels by a slip that varies smoothly.

    Of the wheels' speed forwards the robot loses the share ``s``, of their turning rate another share: each is
    ``2 * mean_ratio * F(x)``, where ``x`` is a stationary first-order Gauss-Markov process with correlation time
    ``correlation_s``, stepped exactly by the elapsed time, and ``F`` is the normal distribution function. A share is
    therefore uniformly distributed from 0 to twice its mean, and never outside.

    ``start``: x_m, y_m, yaw_rad. ``mean_ratio``: at most 0.5.
    """

    def __init__(
        self, rng: np.random.Generator, mean_ratio: float, correlation_s: float, start: tuple[float, float, float]
    ) -> None:
        self._rng, self._mean_ratio, self._correlation_s = rng, mean_ratio, correlation_s
        self._forward, self._turn = rng.standard_normal(HEADINGS).tolist()
        self._x_m, self._y_m, self._yaw_rad = start

    @property
    def wheels(self) -> tuple[float, float, float]:
        """Where the robot would be without slip, as its wheels tell: x_m, y_m, yaw_rad."""
        return self._x_m, self._y_m, math.remainder(self._yaw_rad, 2 * math.pi)

    def roll(self, v_mps: float, omega_radps: float, dt_s: float) -> tuple[float, float]:
        """Turn the wheels at these speeds for a time; return the robot's own speeds (m/s, rad/s)."""
        midway = self._yaw_rad + omega_radps * dt_s / 2
        self._x_m += v_mps * dt_s * math.cos(midway)
        self._y_m += v_mps * dt_s * math.sin(midway)
        self._yaw_rad += omega_radps * dt_s
        kept = math.exp(-dt_s / self._correlation_s)
        fresh = math.sqrt(1 - kept**2)
        forward, turn = self._rng.standard_normal(HEADINGS).tolist()
        self._forward = kept * self._forward + fresh * forward
        self._turn = kept * self._turn + fresh * turn
        return v_mps * (1 - self._share(self._forward)), omega_radps * (1 - self._share(self._turn))

    def _share(self, normal: float) -> float:
        return self._mean_ratio * (1 + math.erf(normal / math.sqrt(2)))
