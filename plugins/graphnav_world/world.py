"""The simulated world with a single rate: every firing drives, renders and publishes."""

from __future__ import annotations

from typing import Literal, NamedTuple

from graphnav import BaseLimits, Finished, Goal, Image, Latest, Map, Motion, Stamp, State, Truth, Twist, param
from graphnav_world.delay_line import DelayLine
from graphnav_world.drive import STANDSTILL
from graphnav_world.late_motion import LateMotion
from graphnav_world.mobile_robot import MobileRobot
from graphnav_world.odometry import displacement
from graphnav_world.vehicle import Base, Pose


class Tick(NamedTuple):
    """Where a firing has driven, and what it publishes of that; ``ends``: the outcome that ends the run, or None."""

    pose: Pose
    time_s: float
    interval_us: int
    motion: Motion | None
    state: State
    goal: Goal | None
    map: Map | None
    limits: BaseLimits | None
    ends: Literal["contact", "goal"] | None


class SingleRate(MobileRobot):
    """A robot that drives by one command a firing, and publishes all that it measures with one stamp."""

    command_timeout_s: float | None = param(
        None, gt=0.0, le=1e6, doc="age beyond which a command counts as Twist(0, 0); null never expires commands"
    )

    def reset(self, seed: int) -> None:
        """Draw the map, its textures and all errors, and put the robot at the start."""
        super().reset(seed)
        self._begin_us: int | None = None
        self._last_us = 0
        self._drive = LateDrive(self._vehicle, self.command_latency_s)
        self._late_motion = LateMotion(self.odometry_delay_frames)
        self._pose, self._wheels = self._vehicle.pose, self._vehicle.wheels

    def _tick(self, command: Latest[Twist], utime: int) -> Tick:
        """Drive until now, and measure."""
        first = self._begin_us is None
        if self._begin_us is None:
            self._begin_us = self._last_us = utime
        time_s = (utime - self._begin_us) / 1e6
        if not first:
            last_us, now_us = self._last_us - self._begin_us, utime - self._begin_us
            self._pose = self._drive.advance(self._obeyed(command), last_us, now_us)
        pose = self._pose
        interval_us, self._last_us = utime - self._last_us, utime
        state = self._state(pose, time_s)
        return Tick(
            pose=pose,
            time_s=time_s,
            interval_us=interval_us,
            motion=None if first else self._motion(interval_us),
            state=state,
            goal=self._beacon(pose),
            map=self._map() if first else None,
            limits=self._base_limits() if first else None,
            ends="contact" if pose.contact else "goal" if state.at_goal else None,
        )

    def _obeyed(self, command: Latest[Twist]) -> Twist:
        stale = self.command_timeout_s is not None and command.age_s > self.command_timeout_s
        return STANDSTILL if command.value is None or stale else command.value

    def _motion(self, interval_us: int) -> Motion:
        """Return the displacement by the wheels in the robot's previous frame, with the errors of odometry."""
        then, self._wheels = self._wheels, self._vehicle.wheels
        moved, interval_us = self._late_motion.next(displacement(then, self._wheels), interval_us)
        [(forward_m, left_m, turn_rad)] = self._errors.read((moved, interval_us / 1e6))
        return Motion(forward_m=forward_m, left_m=left_m, turn_rad=turn_rad, interval_us=interval_us)


class WorldOutputs(NamedTuple):
    """Outputs of the world at a tick: ``map`` and ``limits`` at the first, ``motion`` and ``truth`` after it.

    The truth only if it is read.
    """

    image: Image
    motion: Motion | None
    state: State
    truth: Truth | None
    goal: Goal | None
    map: Map | None
    limits: BaseLimits | None


class CameraWorld(SingleRate):
    """A robot that publishes all that it measures with the frame of its camera."""

    def step(self, command: Latest[Twist], utime: Stamp) -> WorldOutputs:
        """Drive until now, render, and publish."""
        tick = self._tick(command, utime)
        image, truth = self._look(tick.pose, tick.time_s, tick.interval_us)
        outputs = WorldOutputs(image, tick.motion, tick.state, truth, tick.goal, tick.map, tick.limits)
        if tick.ends:
            raise Finished(tick.ends, outputs)
        return outputs


class Pymunk(CameraWorld):
    """A robot with a camera in a world of walls, obstacles and floor, in a pymunk space.

    Each firing drives the period since the last frame with the command sampled then, renders the camera image, and
    publishes it, with its ground truth if that is read. It ends the run with ``goal`` when the robot's centre is in the
    map's goal region, and with ``contact`` at the first touch.

    Everything has the stamp of the frame: truth, state and the middle of the exposure. With ``command_latency_s`` a
    command acts that long after the last frame, which need not be a multiple of the period.
    """


class LateDrive:
    """Drives a vehicle by one command a period, each of which acts ``latency_s`` after the period's beginning.

    The time need not be a multiple of the period. Until the first command acts the robot stands.
    """

    def __init__(self, vehicle: Base, latency_s: float) -> None:
        self._vehicle = vehicle
        self._commands: DelayLine[Twist] = DelayLine(round(1e6 * latency_s))
        self._twist = STANDSTILL

    def advance(self, command: Twist, begin_us: int, until_us: int) -> Pose:
        """Drive over a period; return the pose at its end, with the minimum clearance during it."""
        self._commands.put(command, begin_us)
        clearances_m = []
        while True:
            for _, twist in self._commands.due(begin_us):
                self._twist = twist
            end_us = min(until_us, self._commands.next_us)
            pose = self._vehicle.advance(self._twist.v_mps, self._twist.omega_radps, end_us / 1e6)
            clearances_m.append(pose.clearance_m)
            if end_us >= until_us:
                return pose._replace(clearance_m=min(clearances_m))
            begin_us = int(end_us)
