"""Drive a vehicle from frame to frame by commands that act late."""

from __future__ import annotations

from graphnav import Twist
from graphnav_world.delay_line import DelayLine
from graphnav_world.drive import STANDSTILL
from graphnav_world.vehicle import Pose, Vehicle


class LateDrive:
    """Drives a vehicle by one command a period, each of which acts ``latency_s`` after the period's beginning.

    The time need not be a multiple of the period. Until the first command acts the robot stands.
    """

    def __init__(self, vehicle: Vehicle, latency_s: float) -> None:
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
