"""Simulate odometry: scale errors, noise, and a drifting pose."""

from __future__ import annotations

import math

import numpy as np

from graphnav import Odometry
from graphnav_world.vehicle import Pose

Axes = tuple[float, float, float]
"""Along the axes of a robot: forward, left, turn."""


def displacement(then: Pose, now: Pose) -> Axes:
    """Return (forward m, left m, turn rad) from one pose to another, in the robot's frame of the first."""
    c, s = math.cos(then.yaw_rad), math.sin(then.yaw_rad)
    x, y = now.x_m - then.x_m, now.y_m - then.y_m
    turn = math.remainder(now.yaw_rad - then.yaw_rad, 2 * math.pi)
    return c * x + s * y, c * y - s * x, turn


class OdometryErrors:
    """Errors of a run: a constant scale of each axis (forward, left, turn), new noise of every reading, and a drift.

    ``scale_ratio``: deviation of the scales from 1; ``rng`` draws the signs. ``noise_ratio``: standard deviation
    of the noise, as a share of the reading. ``drift_radps``: constant bias of the turning rate.
    """

    def __init__(
        self, rng: np.random.Generator, scale_ratio: float, noise_ratio: float, drift_radps: float = 0.0
    ) -> None:
        self._rng, self._noise_ratio, self._drift_radps = rng, noise_ratio, drift_radps
        self._scale: list[float] = (1 + scale_ratio * rng.choice([-1.0, 1.0], size=3)).tolist()

    def read(self, *true: tuple[Axes, float]) -> list[Axes]:
        """Return one reading of true values: all of them have the same errors.

        Each comes with the time in seconds that it covers: a displacement with its interval, speeds with 1.
        """
        forward, left, turn = self._scale
        noise = self._rng.standard_normal(3).tolist()
        more_forward, more_left, more_turn = (1 + self._noise_ratio * one for one in noise)
        read = [(x * forward * more_forward, y * left * more_left, z * turn * more_turn) for (x, y, z), _ in true]
        if self._drift_radps:
            read = [(x, y, z + self._drift_radps * time_s) for (x, y, z), (_, time_s) in zip(read, true, strict=True)]
        return read


class DeadReckoning:
    """Accumulates displacements as a robot's odometry does, from (0, 0, 0) at the start and time zero."""

    def __init__(self, start: Pose, errors: OdometryErrors) -> None:
        self._then, self._errors = start, errors
        self._then_s = 0.0
        self._x_m = self._y_m = self._yaw_rad = 0.0

    def read(self, now: Pose, time_s: float) -> Odometry:
        """Return the pose and the speeds of odometry; ``now`` is the pose by the wheels at this time."""
        moved, speeds = displacement(self._then, now), (now.v_mps, 0.0, now.omega_radps)
        (forward_m, left_m, turn_rad), (v_mps, _, omega_radps) = self._errors.read(
            (moved, time_s - self._then_s), (speeds, 1.0)
        )
        c, s = math.cos(self._yaw_rad), math.sin(self._yaw_rad)
        self._x_m += c * forward_m - s * left_m
        self._y_m += s * forward_m + c * left_m
        self._yaw_rad = math.remainder(self._yaw_rad + turn_rad, 2 * math.pi)
        self._then, self._then_s = now, time_s
        return Odometry(x_m=self._x_m, y_m=self._y_m, yaw_rad=self._yaw_rad, v_mps=v_mps, omega_radps=omega_radps)
