"""Base of the simulated robots: how they drive, and what they are told of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from graphnav import BaseLimits, Goal, param
from graphnav_world.odometry import OdometryErrors
from graphnav_world.simulation import Simulation
from graphnav_world.slip import Slip
from graphnav_world.vehicle import Base, Limits, Pose, Vehicle

ODOMETRY, SLIP, DRIFT, BEACON, BEARING, DISTANCE = 2, 20, 21, 22, 23, 24
"""Parts of the seeds: each drawing has a generator of its own."""
_OF_ODOMETRY = ("motion", "odometry")
"""As the worlds call it."""
_OF_BEACON = ("goal",)


class MobileRobot(Simulation):
    """A robot that drives in a simulated world, with odometry and a beacon at the goal."""

    max_speed_mps: float = param(0.5, gt=0.0, le=20.0, doc="maximum speed of the drive, forwards and backwards")
    max_turn_radps: float = param(2.0, gt=0.0, le=20.0, doc="maximum turning rate of the drive, to either side")
    speed_up_s: float = param(0.25, gt=0.0, le=60.0, doc="time from rest to the maximum speed; more is more sluggish")
    turn_up_s: float = param(0.25, gt=0.0, le=60.0, doc="time from rest to the maximum turning rate")
    command_latency_s: float = param(
        0.0, ge=0.0, le=10.0, doc="time by which every command acts later; until the first one acts the robot stands"
    )
    slip_ratio: float = param(
        0.0,
        ge=0.0,
        le=0.5,
        doc="mean share of the wheels' speed, and another one of their turning rate, that is lost on the floor: each "
        "varies by itself, uniformly distributed from 0 to twice this; odometry measures the wheels",
    )
    slip_correlation_s: float = param(
        1.0, gt=0.0, le=1000.0, doc="correlation time of the slip; more lets it vary more slowly"
    )
    odometry_scale_ratio: float = param(
        0.02,
        ge=0.0,
        lt=1.0,
        doc="constant relative error of odometry in a run; the seed draws the signs",
        changes=_OF_ODOMETRY,
    )
    odometry_noise_ratio: float = param(
        0.01,
        ge=0.0,
        lt=1.0,
        doc="standard deviation of odometry's random error, as a share of each displacement",
        changes=_OF_ODOMETRY,
    )
    odometry_drift_degps: float = param(
        0.0,
        ge=0.0,
        le=360.0,
        doc="constant error of the measured turning rate in a run; the seed draws the sign",
        changes=_OF_ODOMETRY,
    )
    odometry_delay_frames: int = param(
        0,
        ge=0,
        le=10,
        doc="number of image periods by which odometry is late: with the stamp of now it tells of the motion then, "
        "standstill before the start",
        changes=_OF_ODOMETRY,
    )
    goal_bearing_sigma_deg: float = param(
        0.0,
        ge=0.0,
        le=180.0,
        doc="standard deviation of the beacon's bearing, independent in every reading",
        changes=_OF_BEACON,
    )
    goal_bearing_bias_deg: float = param(
        0.0,
        ge=0.0,
        le=180.0,
        doc="constant error of the beacon's bearing in a run; the seed draws the sign",
        changes=_OF_BEACON,
    )
    goal_distance_ratio: float = param(
        0.0,
        ge=0.0,
        lt=1.0,
        doc="constant relative error of the beacon's distance in a run; the seed draws the sign",
        changes=_OF_BEACON,
    )

    def reset(self, seed: int) -> None:
        """Draw the map, its textures and all errors, and put the robot at the start."""
        super().reset(seed)
        limits = Limits(self.max_speed_mps, self.max_turn_radps, self.speed_up_s, self.turn_up_s)
        slip = None
        if self.slip_ratio:
            rng = np.random.default_rng([seed, SLIP])
            slip = Slip(rng, self.slip_ratio, self.slip_correlation_s, self._draw.start)
        self._vehicle = self._new_base(limits, slip)
        self._faces = self._faces.moved_by(self._vehicle.movers)
        self._errors = OdometryErrors(
            np.random.default_rng([seed, ODOMETRY]),
            self.odometry_scale_ratio,
            self.odometry_noise_ratio,
            drawn_sign((seed, DRIFT)) * math.radians(self.odometry_drift_degps),
        )
        self._beacon_errors = BeaconErrors(
            np.random.default_rng([seed, BEACON]),
            math.radians(self.goal_bearing_sigma_deg),
            drawn_sign((seed, BEARING)) * math.radians(self.goal_bearing_bias_deg),
            1 + drawn_sign((seed, DISTANCE)) * self.goal_distance_ratio,
        )

    def _new_base(self, limits: Limits, slip: Slip | None) -> Base:
        """Return the base, at the start of the map."""
        return Vehicle(self._draw.bodies, self._draw.start, self._radius_m, limits, slip, self.robot_size_m)

    def _base_limits(self) -> BaseLimits:
        """Return what the drive can do: what `Vehicle` keeps of every command, and slip only shortens its way."""
        accel_mps2 = self.max_speed_mps / self.speed_up_s
        return BaseLimits(
            max_speed_mps=self.max_speed_mps,
            max_turn_radps=self.max_turn_radps,
            max_accel_mps2=accel_mps2,
            max_decel_mps2=accel_mps2,
            max_turn_accel_radps2=self.max_turn_radps / self.turn_up_s,
            latency_s=self.command_latency_s,
        )

    def _beacon(self, pose: Pose) -> Goal | None:
        if not len(self._draw.goal_m):
            return None
        x, y = self._goal_center_m[0] - pose.x_m, self._goal_center_m[1] - pose.y_m
        bearing = math.remainder(math.atan2(y, x) - pose.yaw_rad, 2 * math.pi)
        return self._beacon_errors.read(bearing, math.hypot(x, y))


@dataclass(frozen=True)
class BeaconErrors:
    """Errors of a run: a constant bias of the bearing and scale of the distance, and new noise of every bearing.

    ``rng`` draws the noise. ``bias_rad``: counterclockwise. ``distance_scale``: 1 is exact.
    """

    rng: np.random.Generator
    sigma_rad: float
    bias_rad: float
    distance_scale: float

    def read(self, bearing_rad: float, distance_m: float) -> Goal:
        """Return what the beacon tells of the true bearing and distance."""
        error_rad = self.bias_rad
        if self.sigma_rad:
            error_rad += self.sigma_rad * float(self.rng.standard_normal())
        if error_rad:
            bearing_rad = math.remainder(bearing_rad + error_rad, 2 * math.pi)
        return Goal(bearing_rad=bearing_rad, distance_m=distance_m * self.distance_scale)


def drawn_sign(seed: Sequence[int]) -> float:
    """Return the sign of a constant error: -1 or 1, each with probability one half."""
    return 1.0 if np.random.default_rng(seed).integers(2) else -1.0
