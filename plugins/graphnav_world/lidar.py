"""The simulated world for a robot that has a lidar, beside the camera or in its place."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from graphnav import (
    BaseLimits,
    Finished,
    Goal,
    Image,
    Latest,
    Map,
    Motion,
    ParamError,
    Scan,
    Stamp,
    State,
    Truth,
    Twist,
    param,
)
from graphnav_world.geometry.rays import Beams, Sides, distances_m
from graphnav_world.vehicle import Pose
from graphnav_world.world import SingleRate

RANGES = 30
"""Part of the seed, as those of `mobile_robot`: the noise of the ranges."""
_OF_SCAN = ("scan",)


class LidarOutputs(NamedTuple):
    """Outputs of the world at a tick: those of `world.pymunk`, the image only where it is read, and the scan."""

    scan: Scan
    image: Image | None
    motion: Motion | None
    state: State
    truth: Truth | None
    goal: Goal | None
    map: Map | None
    limits: BaseLimits | None


class Lidar(SingleRate):
    """The world of `world.pymunk` for a robot with a lidar; all else is the same, with the same seeds.

    The lidar is above the robot's centre. Its beams are level, spread evenly over ``lidar_fov_deg`` about forward, the
    first and the last at the ends, and measure to the first wall or obstacle, moving or not, that is as high as they
    are. All are measured at the stamp of the frame, ``rate_hz`` times a second. A range has normally distributed noise;
    one that is below ``lidar_min_m`` with it is ``lidar_min_m``, and one beyond ``lidar_max_m`` is infinite.

    Without a stage or an output that reads image or truth the camera is not rendered, which saves most of the time.

    Scans are measurements, as images are, and of no stage that sees the truth: any method may read them.
    """

    lidar_fov_deg: float = param(270.0, ge=1.0, le=360.0, doc="field of view, half to either side", changes=_OF_SCAN)
    lidar_beams: int = param(720, ge=2, le=20_000, doc="number of beams in the field of view", changes=_OF_SCAN)
    lidar_min_m: float = param(0.1, ge=0.0, le=100.0, doc="minimum distance that is measured", changes=_OF_SCAN)
    lidar_max_m: float = param(
        10.0, gt=0.0, le=1000.0, doc="maximum distance that is measured; 30 as the lidar of a Jackal", changes=_OF_SCAN
    )
    lidar_noise_m: float = param(
        0.01,
        ge=0.0,
        le=10.0,
        doc="standard deviation of the noise of a range, independent in every beam and scan; seeded",
        changes=_OF_SCAN,
    )
    lidar_height_m: float = param(
        0.2, ge=0.0, le=100.0, doc="height of the beams above the floor: they pass over what is lower", changes=_OF_SCAN
    )

    def check(self) -> None:
        """Read the map, and compare the ranges.

        Raises
        ------
        ParamError
            The map does not exist, or the lidar measures nothing.
        UserError
            The map is invalid; all problems with their locations in the map's file.
        """
        if self.lidar_min_m >= self.lidar_max_m:
            what = f"'lidar_min_m' is {self.lidar_min_m:g}, not below 'lidar_max_m' {self.lidar_max_m:g}"
            raise ParamError("lidar_min_m", what, "make it smaller")
        super().check()

    def reset(self, seed: int) -> None:
        """Draw the map, its textures and all errors, and put the robot at the start."""
        super().reset(seed)
        self._sides = Sides(self._draw.bodies, self._vehicle.movers, self.lidar_height_m)
        # The field of view of 360 degrees ends where it begins: one beam is not there twice.
        steps = self.lidar_beams if self.lidar_fov_deg == 360.0 else self.lidar_beams - 1
        fov_rad = math.radians(self.lidar_fov_deg)
        self._beams = Beams(-fov_rad / 2, fov_rad / steps, self.lidar_beams)
        self._range_noise = np.random.default_rng([seed, RANGES])
        self._has_picture = self._has_truth or self.is_read("image")

    def step(self, command: Latest[Twist], utime: Stamp) -> LidarOutputs:
        """Drive until now, scan, render where that is read, and publish."""
        tick = self._tick(command, utime)
        scan = self._scan(tick.pose, tick.time_s)
        image, truth = self._look(tick.pose, tick.time_s, tick.interval_us) if self._has_picture else (None, None)
        outputs = LidarOutputs(scan, image, tick.motion, tick.state, truth, tick.goal, tick.map, tick.limits)
        if tick.ends:
            raise Finished(tick.ends, outputs)
        return outputs

    def _scan(self, pose: Pose, time_s: float) -> Scan:
        c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
        sides = (self._sides.at(time_s) - (pose.x_m, pose.y_m)) @ np.array([[c, -s], [s, c]])
        ranges_m = distances_m(sides, self._beams)
        ranges_m += self.lidar_noise_m * self._range_noise.standard_normal(len(ranges_m))
        np.maximum(ranges_m, self.lidar_min_m, out=ranges_m)
        ranges_m[ranges_m > self.lidar_max_m] = math.inf
        return Scan(
            angle_min_rad=self._beams.first_rad,
            angle_increment_rad=self._beams.step_rad,
            range_min_m=self.lidar_min_m,
            range_max_m=self.lidar_max_m,
            ranges_m=ranges_m.astype(np.float32),
        )
