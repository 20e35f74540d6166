"""Drive a vehicle by commands that expire, and interpolate its poses."""

from __future__ import annotations

import math
from bisect import bisect_left

from graphnav import Latest, Twist
from graphnav_world.delay_line import DelayLine
from graphnav_world.vehicle import SUBSTEP_S, Base, Pose

STANDSTILL = Twist(v_mps=0.0, omega_radps=0.0)
_SUBSTEP_US = round(SUBSTEP_S * 1e6)


class Drive:
    """Drives a vehicle by the last command until it is older than ``timeout_s``; then brakes.

    Everything that a command does it does ``latency_s`` later. Times are microseconds from the start.
    """

    def __init__(self, vehicle: Base, timeout_s: float, latency_s: float = 0.0) -> None:
        self._vehicle, self._timeout_s = vehicle, timeout_s
        self._heard: DelayLine[Latest[Twist]] = DelayLine(round(1e6 * latency_s))
        self._twist, self._expires_us = STANDSTILL, 0
        self._times_us = [0]
        self._pose = vehicle.pose
        self._wheels = [vehicle.wheels]

    def hear(self, command: Latest[Twist], now_us: int) -> None:
        """Apply the newest command from now and the latency on, for ``timeout_s`` minus its age."""
        self._heard.put(command, now_us)

    def _obey(self, command: Latest[Twist], now_us: int) -> None:
        if command.value is None or command.age_s > self._timeout_s:
            self._twist = STANDSTILL
            return
        self._twist = command.value
        self._expires_us = now_us + round(1e6 * (self._timeout_s - command.age_s))

    def advance(self, until_us: int) -> Pose:
        """Drive until a time; return the pose then. Its clearance is the minimum since the last call."""
        begin = self._pose
        self._times_us, self._wheels = self._times_us[-1:], self._wheels[-1:]
        clearances_m = []
        while (now_us := self._times_us[-1]) < until_us:
            for heard_us, command in self._heard.due(now_us):
                self._obey(command, heard_us)
            alive = now_us < self._expires_us
            twist = self._twist if alive else STANDSTILL
            end_us = min(until_us, self._expires_us) if alive else until_us
            self._substep(twist, int(min(now_us + _SUBSTEP_US, end_us, self._heard.next_us)))
            clearances_m.append(self._pose.clearance_m)
        return self._pose._replace(clearance_m=min(clearances_m, default=begin.clearance_m))

    def wheels_at(self, time_us: int) -> Pose:
        """Return the pose by the wheels at a time of the last `advance`, interpolated between steps of up to 10 ms."""
        k = bisect_left(self._times_us, time_us)
        if self._times_us[k] == time_us:
            return self._wheels[k]
        then_us, end_us = self._times_us[k - 1 : k + 1]
        return _between(self._wheels[k - 1], self._wheels[k], (time_us - then_us) / (end_us - then_us))

    def _substep(self, twist: Twist, until_us: int) -> None:
        pose = self._vehicle.advance(twist.v_mps, twist.omega_radps, until_us / 1e6)
        wheels = self._vehicle.wheels
        if pose.contact:
            pose, wheels = (one._replace(v_mps=0.0, omega_radps=0.0) for one in (pose, wheels))
        self._times_us.append(until_us)
        self._pose = pose
        self._wheels.append(wheels)


def _between(then: Pose, now: Pose, share: float) -> Pose:
    """Return the pose interpolated between two poses at this share."""
    turn = math.remainder(now.yaw_rad - then.yaw_rad, 2 * math.pi)
    return now._replace(
        x_m=then.x_m + share * (now.x_m - then.x_m),
        y_m=then.y_m + share * (now.y_m - then.y_m),
        yaw_rad=math.remainder(then.yaw_rad + share * turn, 2 * math.pi),
        v_mps=then.v_mps + share * (now.v_mps - then.v_mps),
        omega_radps=then.omega_radps + share * (now.omega_radps - then.omega_radps),
    )
