"""The robot's body in a pymunk space: a unicycle with limits, contacts, clearance, moving obstacles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import pymunk

from graphnav_world.geometry.movers import Mover, Walker, movers_of
from graphnav_world.geometry.scene import Body
from graphnav_world.slip import Slip

SUBSTEP_S = 0.01
FARTHEST_M = 1000.0
ROBOT, OTHER = 1, 2
OTHERS = pymunk.ShapeFilter(mask=OTHER)
SEARCH_MARGIN_M = 1e-3


@dataclass(frozen=True)
class Limits:
    """Limits of the drive: maximum speeds, and the time to reach them from rest."""

    speed_mps: float
    turn_radps: float
    speed_up_s: float
    turn_up_s: float


class Pose(NamedTuple):
    """Pose of the robot in W, its speeds, and its minimum clearance since the last pose."""

    x_m: float
    y_m: float
    yaw_rad: float
    v_mps: float
    omega_radps: float
    clearance_m: float
    contact: bool


class Vehicle:
    """A disc that drives forwards and turns; it cannot slip sideways.

    Steps of at most 10 ms; the first contact stops it permanently. Commands and limits are those of its wheels, which
    the robot follows exactly unless there is a ``slip``.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        start: tuple[float, float, float],
        radius_m: float,
        limits: Limits,
        slip: Slip | None = None,
    ) -> None:
        self._space = pymunk.Space()
        self._limits, self._radius_m, self._slip = limits, radius_m, slip
        self._time_s = 0.0
        self._v_mps = self._omega_radps = 0.0
        self._speeds = (0.0, 0.0)
        self._contact = False
        self.movers = movers_of(body.course for body in bodies if body.course is not None)
        """The bodies that move, in their order."""
        self._walkers = [mover for mover in self.movers if isinstance(mover, Walker)]
        self._moving: list[tuple[pymunk.Body, Mover]] = []
        movers = iter(self.movers)
        for body in bodies:
            self._add(body, None if body.course is None else next(movers))
        self._robot = pymunk.Body(mass=10.0, moment=math.inf)
        self._robot.position = start[0], start[1]
        self._robot.angle = start[2]
        rim = pymunk.Circle(self._robot, radius_m)
        rim.collision_type, rim.filter = ROBOT, pymunk.ShapeFilter(categories=ROBOT)
        self._space.add(self._robot, rim)
        self._space.on_collision(ROBOT, OTHER, begin=self._touch)
        self._fastest_mps = max((mover.speed_mps for mover in self.movers), default=0.0)
        self._search_m = FARTHEST_M
        self._here_m = self._clearance_m = self._find_nearest_m()

    @property
    def pose(self) -> Pose:
        """The current pose; its clearance is the minimum during the last `advance`."""
        x, y = self._robot.position
        clearance = 0.0 if self._contact else self._clearance_m
        yaw = math.remainder(self._robot.angle, 2 * math.pi)
        return Pose(x, y, yaw, *self._speeds, clearance, self._contact)

    @property
    def wheels(self) -> Pose:
        """Pose and speeds as the wheels tell them, which odometry measures: the `pose` itself without slip."""
        if self._slip is None:
            return self.pose
        clearance = 0.0 if self._contact else self._clearance_m
        return Pose(*self._slip.wheels, self._v_mps, self._omega_radps, clearance, self._contact)

    def advance(self, v_mps: float, omega_radps: float, until_s: float) -> Pose:
        """Drive towards a command until a time; return the pose then, or where the first contact was."""
        steps = max(1, math.ceil((until_s - self._time_s) / SUBSTEP_S - 1e-9))
        begin_s, dt_s = self._time_s, (until_s - self._time_s) / steps
        self._clearance_m = self._here_m
        v_mps = _within(v_mps, self._limits.speed_mps)
        omega_radps = _within(omega_radps, self._limits.turn_radps)
        for k in range(steps):
            if self._contact:
                break
            self._tell_walkers()
            self._time_s = until_s if k == steps - 1 else begin_s + (k + 1) * dt_s
            self._step(v_mps, omega_radps, dt_s)
            self._here_m = self._find_nearest_m()
            self._clearance_m = min(self._clearance_m, self._here_m)
        return self.pose

    def _step(self, v_mps: float, omega_radps: float, dt_s: float) -> None:
        """Drive one step towards speeds within the limits."""
        limits, robot = self._limits, self._robot
        if v_mps != self._v_mps:
            self._v_mps = _towards(self._v_mps, v_mps, limits.speed_mps * (dt_s / limits.speed_up_s))
        if omega_radps != self._omega_radps:
            self._omega_radps = _towards(self._omega_radps, omega_radps, limits.turn_radps * (dt_s / limits.turn_up_s))
            robot.angular_velocity = self._omega_radps
        v, omega = self._v_mps, self._omega_radps
        if self._slip is not None:
            v, omega = self._slip.roll(v, omega, dt_s)
            robot.angular_velocity = omega
        self._speeds = v, omega
        midway = robot.angle + omega * dt_s / 2
        robot.velocity = v * math.cos(midway), v * math.sin(midway)
        for carrier, mover in self._moving:
            x, y = mover.at(self._time_s)
            from_x, from_y = carrier.position
            carrier.velocity = (x - from_x) / dt_s, (y - from_y) / dt_s
        self._space.step(dt_s)
        self._search_m += (abs(self._v_mps) + self._fastest_mps) * dt_s

    def _tell_walkers(self) -> None:
        """Show the robot to those who wait for it."""
        for walker in self._walkers:
            walker.see(self._time_s, self._robot.position, self._robot.velocity)

    def _add(self, body: Body, mover: Mover | None) -> None:
        carrier = self._space.static_body
        if mover is not None:
            carrier = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
            carrier.position = mover.at(0.0)
            self._space.add(carrier)
            self._moving.append((carrier, mover))
        for part in body.parts:
            shape = pymunk.Poly(carrier, part.tolist())
            shape.collision_type, shape.filter = OTHER, pymunk.ShapeFilter(categories=OTHER)
            self._space.add(shape)

    def _touch(self, _arbiter: pymunk.Arbiter, _space: pymunk.Space, _data: object) -> None:
        self._contact = True

    def _find_nearest_m(self) -> float:
        """Return the distance from the rim to the nearest body, 1000 m if there is none.

        Since the last search the nearest body has not moved away faster than it and the robot drive, so that a short
        search finds it.
        """
        found = self._space.point_query_nearest(self._robot.position, self._search_m, OTHERS)
        if found is None:
            return FARTHEST_M
        distance_m: float = found.distance
        self._search_m = max(distance_m, 0.0) + SEARCH_MARGIN_M
        return distance_m - self._radius_m


def _towards(now: float, wanted: float, max_change: float) -> float:
    """Return the speed after a step: closer to the wanted one by at most this change."""
    return min(max(wanted, now - max_change), now + max_change)


def _within(wanted: float, maximum: float) -> float:
    return min(max(wanted, -maximum), maximum)
