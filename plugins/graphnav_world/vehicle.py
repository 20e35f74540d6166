"""The robot's body in a pymunk space: a unicycle with limits, contacts, clearance, moving obstacles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
import pymunk

from graphnav.arrays import Doubles
from graphnav_world.geometry.movers import Mover, Walker, movers_of
from graphnav_world.geometry.scene import Body
from graphnav_world.slip import Slip

SUBSTEP_S = 0.01
FARTHEST_M = 1000.0
ROBOT, OTHER = 1, 2
OTHERS = pymunk.ShapeFilter(mask=OTHER)
SEARCH_MARGIN_M = 1e-3
CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
"""Of a rectangle, in halves of its length and width."""


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


class Base(Protocol):
    """A base that drives a robot in a world. The first contact stops it permanently."""

    movers: tuple[Mover, ...]
    """The bodies that move, in their order."""

    @property
    def pose(self) -> Pose:
        """The current pose; its clearance is the minimum during the last `advance`."""
        ...

    @property
    def wheels(self) -> Pose:
        """Pose and speeds as the wheels tell them, which odometry measures."""
        ...

    def advance(self, v_mps: float, omega_radps: float, until_s: float) -> Pose:
        """Drive towards a command until a time; return the pose then, or where the first contact was."""
        ...


class Vehicle:
    """A disc, or a rectangle about its centre, that drives forwards and turns; it cannot slip sideways.

    Steps of at most 10 ms; the first contact stops it permanently. Commands and limits are those of its wheels, which
    the robot follows exactly unless there is a ``slip``. ``size_m``: length and width of a rectangle; ``radius_m`` is
    then that of the circle around it.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        start: tuple[float, float, float],
        radius_m: float,
        limits: Limits,
        slip: Slip | None = None,
        size_m: tuple[float, float] | None = None,
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
        self._sides: dict[pymunk.Shape, Doubles] = {}
        movers = iter(self.movers)
        for body in bodies:
            self._add(body, None if body.course is None else next(movers))
        self._robot = pymunk.Body(mass=10.0, moment=math.inf)
        self._robot.position = start[0], start[1]
        self._robot.angle = start[2]
        self._half_m = None if size_m is None else (size_m[0] / 2, size_m[1] / 2)
        rim = pymunk.Circle(self._robot, radius_m) if size_m is None else pymunk.Poly.create_box(self._robot, size_m)
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
        v_mps = within(v_mps, self._limits.speed_mps)
        omega_radps = within(omega_radps, self._limits.turn_radps)
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
            self._v_mps = towards(self._v_mps, v_mps, limits.speed_mps * (dt_s / limits.speed_up_s))
        if omega_radps != self._omega_radps:
            self._omega_radps = towards(self._omega_radps, omega_radps, limits.turn_radps * (dt_s / limits.turn_up_s))
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
            self._sides[shape] = np.stack([part, np.roll(part, -1, axis=0)], axis=1)
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
        if self._half_m is not None:
            return self._find_nearest_to_rectangle_m(distance_m, self._half_m)
        return distance_m - self._radius_m

    def _find_nearest_to_rectangle_m(self, from_centre_m: float, half_m: tuple[float, float]) -> float:
        """Return the distance from the rectangle to the nearest body, whose distance from the centre is given.

        Nearest to the rectangle may be another body, farther from the centre by at most the difference of the radii of
        the circles around and inside of the rectangle. The nearest points of two include a corner of one of them.
        """
        robot = self._robot
        reach_m = max(from_centre_m, 0.0) + self._radius_m - min(half_m) + SEARCH_MARGIN_M
        shapes = [found.shape for found in self._space.point_query(robot.position, reach_m, OTHERS)]
        sides = [self._sides[shape] + shape.body.position for shape in shapes if shape is not None]
        if not sides:
            return FARTHEST_M
        c, s = math.cos(robot.angle), math.sin(robot.angle)
        in_robot = (np.concatenate(sides) - robot.position) @ np.array([[c, -s], [s, c]])
        begin, along = in_robot[:, 0], in_robot[:, 1] - in_robot[:, 0]
        to_rectangle = np.maximum(np.abs(begin) - half_m, 0.0)
        to_corners = np.array(half_m) * CORNERS[:, None] - begin
        share = np.clip((to_corners * along).sum(axis=2) / np.maximum((along * along).sum(axis=1), 1e-18), 0.0, 1.0)
        away = to_corners - share[..., None] * along
        return math.sqrt(min((to_rectangle**2).sum(axis=1).min(), (away**2).sum(axis=2).min()))


def towards(now: float, wanted: float, max_change: float) -> float:
    """Return the speed after a step: closer to the wanted one by at most this change."""
    return min(max(wanted, now - max_change), now + max_change)


def within(wanted: float, maximum: float) -> float:
    """Return the speed nearest to the wanted one that is not faster than the maximum, in either direction."""
    return min(max(wanted, -maximum), maximum)
