"""The simulated world as a robot on a bus: sensors with separate rates, commands that expire."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from graphnav import (
    BaseLimits,
    Finished,
    Goal,
    Image,
    Latest,
    Map,
    Odometry,
    ParamError,
    Stamp,
    Stamped,
    State,
    Truth,
    Twist,
    UserError,
    param,
)
from graphnav_world.drive import Drive
from graphnav_world.late_motion import LatePoses
from graphnav_world.mobile_robot import MobileRobot
from graphnav_world.odometry import DeadReckoning
from graphnav_world.vehicle import Pose

REPEAT_HZ = 0.5
"""Period of the map and of the base's limits, which are repeated for late subscribers."""
_MAX_PENDING = 2
"""Maximum number of pending odometry samples; a late step loses older ones, as a driver's buffer does."""


class RobotOutputs(NamedTuple):
    """Outputs of the robot at a step; None for those that are not due."""

    image: Image | None
    odometry: Stamped[Odometry] | None
    state: State | None
    truth: Truth | None
    goal: Goal | None
    map: Map | None
    limits: BaseLimits | None


class Robot(MobileRobot):
    """The world of `world.pymunk` as a robot on a bus, with separate rates of its drive and sensors.

    Each firing is a step of the physics, over all the time since the last one, in steps of at most 10 ms. A command
    acts from the step after its arrival until it is older than ``command_timeout_s``; then, or before the first
    command, the drive brakes within its limits.

    Images, truth (with the image, if it is read; its flow since the last image), state, beacon, map and limits of the
    base (every 2 s) have the stamp of the first step at which they are due. Odometry has its own stamps: it samples the
    pose exactly at its jittered times, and is published at the first step at or after each. Its frame is the start
    pose; errors accumulate. With ``odometry_delay_frames`` a sample is of the newest pose sampled that many image
    periods ago or earlier.

    It ends the run with ``goal`` when the robot's centre is in the map's goal region, and with ``contact`` at the first
    touch. With ``ends: false`` the run continues, and the robot stands.
    """

    rate_hz: float = param(100.0, gt=0.0, le=10_000.0, doc="steps of the physics per second")
    image_hz: float = param(10.0, gt=0.0, le=10_000.0, doc="images per second")
    image_jitter_s: float = param(0.0, ge=0.0, le=1e6, doc="maximum time by which an image is early or late; seeded")
    odometry_hz: float = param(50.0, gt=0.0, le=10_000.0, doc="odometry samples per second", changes=("odometry",))
    odometry_jitter_s: float = param(
        0.004,
        ge=0.0,
        le=1e6,
        doc="maximum time by which an odometry sample is early or late; seeded",
        changes=("odometry",),
    )
    state_hz: float = param(20.0, gt=0.0, le=10_000.0, doc="true states per second; equal to rate_hz for every step")
    goal_hz: float = param(5.0, gt=0.0, le=10_000.0, doc="readings of the goal's beacon per second", changes=("goal",))
    command_timeout_s: float = param(0.5, gt=0.0, le=1e6, doc="age beyond which a command counts as Twist(0, 0)")
    ends: bool = param(True, doc="whether the goal or a contact ends the run; else the robot stands from then on")

    def check(self) -> None:
        """Compare the rates and read the map.

        Raises
        ------
        ExceptionGroup
            Sensors are faster than the physics or their jitter reaches half of their period, or the map cannot be read.
        """
        errors: list[Exception] = list(self._wrong_rates())
        try:
            super().check()
        except (ParamError, UserError) as error:
            errors.append(error)
        if errors:
            raise ExceptionGroup("the simulated robot", errors)

    def _wrong_rates(self) -> Iterator[ParamError]:
        for name in ("image_hz", "odometry_hz", "state_hz", "goal_hz"):
            if (hz := getattr(self, name)) > self.rate_hz:
                what = f"'{name}' is {hz:g}, but the physics steps only {self.rate_hz:g} times a second"
                yield ParamError(name, what, f"set {name} to at most rate_hz")
        for name, hz in (("image_jitter_s", self.image_hz), ("odometry_jitter_s", self.odometry_hz)):
            if (jitter_s := getattr(self, name)) >= 0.5 / hz:
                what = f"'{name}' is {jitter_s:g}, but must be less than half of the period of {1 / hz:g} s"
                yield ParamError(name, what, "set a smaller jitter or a lower rate")

    def reset(self, seed: int) -> None:
        """Draw the map, its textures, the errors and the jitter, and put the robot at the start."""
        super().reset(seed)
        self._images = Schedule(self.image_hz, self.image_jitter_s, (seed, 3))
        self._samples = Schedule(self.odometry_hz, self.odometry_jitter_s, (seed, 4))
        self._states, self._goals, self._maps = map(Schedule, (self.state_hz, self.goal_hz, REPEAT_HZ))
        self._drive = Drive(self._vehicle, self.command_timeout_s, self.command_latency_s)
        self._late_poses = LatePoses(self._vehicle.wheels, round(1e6 * self.odometry_delay_frames / self.image_hz))
        self._reckoning = DeadReckoning(self._vehicle.wheels, self._errors)
        self._pending: deque[Stamped[Odometry]] = deque(maxlen=_MAX_PENDING)
        self._begin_us: int | None = None
        self._image_us = 0
        self._clearance_m = math.inf
        self._has_ended = False

    def step(self, command: Latest[Twist], utime: Stamp) -> RobotOutputs:
        """Drive until now, apply the newest command, and publish the outputs that are due."""
        if self._begin_us is None:
            self._begin_us = utime
        now_us = utime - self._begin_us
        pose = self._drive.advance(now_us)
        ends = not self._has_ended and (pose.contact or self._at_goal(pose))
        self._has_ended |= ends
        self._drive.hear(Latest() if self._has_ended else command, now_us)
        image, truth = self._picture(pose, now_us)
        repeats = bool(self._maps.due(now_us))
        outputs = RobotOutputs(
            image=image,
            odometry=self._odometry(now_us),
            state=self._report(pose, now_us, is_last=ends),
            truth=truth,
            goal=self._beacon(pose) if self._goals.due(now_us) else None,
            map=self._map() if repeats else None,
            limits=self._base_limits() if repeats else None,
        )
        if ends and self.ends:
            raise Finished("contact" if pose.contact else "goal", outputs)
        return outputs

    def _base_limits(self) -> BaseLimits:
        """Return what the drive can do; a command waits for the next step of the physics, too."""
        found = super()._base_limits()
        return replace(found, latency_s=found.latency_s + 1 / self.rate_hz)

    def _picture(self, pose: Pose, now_us: int) -> tuple[Image | None, Truth | None]:
        if not self._images.due(now_us):
            return None, None
        interval_us, self._image_us = now_us - self._image_us, now_us
        return self._look(pose, now_us / 1e6, interval_us)

    def _odometry(self, now_us: int) -> Stamped[Odometry] | None:
        """Read the samples that are due; return the oldest pending one."""
        assert self._begin_us is not None
        for time_us in self._samples.due(now_us):
            pose, measured_us = self._late_poses.next(self._drive.wheels_at(time_us), time_us)
            reading = self._reckoning.read(pose, measured_us / 1e6)
            self._pending.append(Stamped(reading, self._begin_us + time_us))
        return self._pending.popleft() if self._pending else None

    def _report(self, pose: Pose, now_us: int, *, is_last: bool) -> State | None:
        """Return the state if it is due, with the minimum clearance since the last one."""
        self._clearance_m = min(self._clearance_m, pose.clearance_m)
        if not self._states.due(now_us) and not is_last:
            return None
        state = self._state(pose._replace(clearance_m=self._clearance_m), now_us / 1e6)
        self._clearance_m = math.inf
        return state


class Schedule:
    """Firing times of a sensor, microseconds from 0 on, each but the first off that of its rate by at most a jitter.

    ``jitter_s``: below half a period, so that the order stays; ``seed`` draws it uniformly to both sides.
    """

    def __init__(self, rate_hz: float, jitter_s: float = 0.0, seed: Sequence[int] = ()) -> None:
        self._rate_hz, self._jitter_s = rate_hz, jitter_s
        self._rng = np.random.default_rng(seed)
        self._count = 0
        self._next_us = 0

    def due(self, now_us: int) -> list[int]:
        """Return the times that have come since the last call, oldest first, each once."""
        times = []
        while self._next_us <= now_us:
            times.append(self._next_us)
            self._count += 1
            jitter_us = 1e6 * self._jitter_s * self._rng.uniform(-1.0, 1.0)
            self._next_us = round(1e6 * self._count / self._rate_hz + jitter_us)
        return times
