"""The control law of [OI] for a robot that cannot drive sideways."""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

import numpy as np

from graphnav import (
    Age,
    BaseLimits,
    Continuity,
    Latest,
    LocalMap,
    ParamError,
    Stage,
    Stamp,
    Steering,
    Twist,
    param,
)

_MARGIN_M = 0.02
"""Distance to keep from obstacles, beyond the radius, where the steering does."""
_TURNING_MARGIN_M = 0.05
"""The same on the arc to where the steering leads, as far as the straight way there keeps it."""
TOLERANCE_M = 0.005
"""How much nearer to what touches it already the robot may come."""
_UNDECLARED_DECEL_MPS2, _UNDECLARED_REACTION_S = 0.5, 0.25
"""Deceleration and reaction to count on where no base declares its limits."""
_KEPT_DELAYS = 5
"""The longest of so many images counts: one that was overtaken delays the next, too."""
_STILL = 1e-6
"""m/s and rad/s: a slower robot drives no arc."""
_SHARES = np.linspace(1.0, 0.1, 10)
"""Of a speed: those that are tried to drive around what the arc of the full speed leads to."""
_NOT_DECLARED, _NEW = Latest[BaseLimits](), Age(0.0)


class Braking(NamedTuple):
    """Deceleration and reaction to count on where the map limits the speed.

    ``ahead_mps2``: deceleration before what ends the way ahead. ``near_mps2``: deceleration before what is nearest to
    the robot in any direction, None to drive past it at any speed. ``reaction_s``: time until braking begins.
    ``turn_radps``: the turning rate that the base has now, from which it gets to another with ``turn_radps2``.
    """

    ahead_mps2: float
    near_mps2: float | None
    reaction_s: float
    turn_radps: float = 0.0
    turn_radps2: float = math.inf


class Nonholonomic(Stage):
    """Speeds of a unicycle from the direction of the control force.

    T = T_m cos(theta) and R = R_m sin(theta) [OI, section 3], T the forward speed and R the turning rate. Beyond a
    right angle the law as published would drive backwards, blind, and turn more slowly the larger the angle: there T is
    0 and R keeps its full value, so that the robot turns on the spot. ``reversing`` is the law as published.

    ``floor_ratio``, ``smoothing_s`` and ``map`` are departures from [OI], off by default. With a local map the robot
    drives no faster than it can stop before the first obstacle or unknown floor ahead; the newest map counts, however
    old it is.

    How well it stops follows from what the base declares on ``limits``: it counts on ``decel_ratio`` of the
    deceleration after ``reaction_ratio`` times the sum of the time between two steerings, their age in a live run (from
    the arrival of the image to this stage), both as measured, the longest of the last 5, and the base's latency. Both
    factors are margins: the first for an obstacle at the edge of the floor that is known, which the robot's rim reaches
    before its centre; the second since a map needs more than one image to show what it did not show before.

    A strong base could then be fast close to obstacles, where neither the map nor the way around a bend is exact. So
    the robot also drives no faster than it can stop, with all of the declared deceleration, within ``map_error_m`` more
    than its distance to the nearest obstacle in any direction. And where it turns, what ends the way ahead is looked
    for on its arc, too, which begins with the turning rate that the base has got to by the declared acceleration: where
    that leads to an obstacle, or past one at less than 5 cm and nearer than the straight way that it turns to, it
    drives more slowly, in a tighter arc, or turns on the spot.

    Without ``limits`` it counts on 0.5 m/s2 after 0.25 s, and only ahead; so it does with a given ``max_decel_mps2``.
    It does not ask for speeds above the declared ones.

    References
    ----------
    .. [OI] N. Ohnishi, A. Imiya, Combination of Supervised and Unsupervised Methods for Navigation Path Mining,
       section 3.
    """

    max_speed_mps: float = param(0.3, gt=0.0, le=1000.0, doc="T_m, speed straight ahead")
    max_turn_radps: float = param(1.2, gt=0.0, le=1000.0, doc="R_m, turning rate at a right angle and beyond")
    floor_ratio: float = param(
        0.0, ge=0.0, le=1.0, doc="minimum speed as a share of max_speed_mps; above 0 the robot never stops to turn"
    )
    smoothing_s: float = param(
        0.0, ge=0.0, le=1e6, doc="time constant of a low-pass of the command; more is smoother and later, 0 is none"
    )

    robot_radius_m: float = param(0.2, gt=0.0, le=10.0, doc="radius of the robot's body; used with a map")
    map_error_m: float = param(
        0.1,
        ge=0.0,
        le=10.0,
        doc="how much nearer than they are obstacles may be on the map: a way past them that is narrower by as much is "
        "driven where the steering leads through it",
    )
    max_decel_mps2: float | None = param(
        None,
        gt=0.0,
        le=100.0,
        doc="deceleration to count on before what ends the way on the map; null: that which the base declares, times "
        "decel_ratio, and all of it before what is nearest; 0.5 if it declares none",
    )
    reaction_s: float | None = param(
        None,
        ge=0.0,
        le=60.0,
        doc="time from what the camera sees to the brakes, where a map limits the speed; null: images, latency and age "
        "as measured and declared, times reaction_ratio; 0.25 if the base declares nothing",
    )
    decel_ratio: float = param(0.5, gt=0.0, le=1.0, doc="share of the declared deceleration to count on ahead")
    reaction_ratio: float = param(
        2.0, ge=1.0, le=100.0, doc="by how much the reaction is longer than from an image to the beginning of braking"
    )
    reversing: bool = param(
        False, doc="the law as published also beyond a right angle: the robot drives backwards, where it does not see"
    )

    def check(self) -> None:
        """Check that the robot is not to reverse and to keep a minimum speed at once."""
        if self.reversing and self.floor_ratio:
            raise ParamError(
                "reversing", "a robot that reverses has no minimum speed", "remove floor_ratio, or reversing"
            )

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Forget the last command."""
        self._last: tuple[int, Twist] | None = None
        self._turn_radps = 0.0
        self._continuity = Continuity()
        self._delays_s: deque[float] = deque(maxlen=_KEPT_DELAYS)

    def step(
        self,
        steering: Steering,
        map: Latest[LocalMap],  # noqa: A002  # the port's name
        stamp: Stamp,
        limits: Latest[BaseLimits] = _NOT_DECLARED,
        age_s: Age = _NEW,
    ) -> Twist:
        """Return the command; low-pass and measured delays restart after a gap of more than 3 periods."""
        if self._continuity.breaks(stamp):
            self._last, self._turn_radps = None, 0.0
            self._delays_s.clear()
        if self._last is not None:
            elapsed_s = (stamp - self._last[0]) * 1e-6
            self._delays_s.append(elapsed_s + age_s)
            self._turn_radps = turned_radps(self._turn_radps, self._last[1].omega_radps, limits.value, elapsed_s)
        theta_rad = steering.theta_rad
        speed_ratio, turn_ratio = math.cos(theta_rad), math.sin(theta_rad)
        if not self.reversing:
            speed_ratio = max(speed_ratio, self.floor_ratio)
            turn_ratio = turn_ratio if abs(theta_rad) <= math.pi / 2 else math.copysign(1.0, theta_rad)
        max_speed_mps, max_turn_radps = self.max_speed_mps, self.max_turn_radps
        if limits.value is not None:
            max_speed_mps = min(max_speed_mps, limits.value.max_speed_mps)
            max_turn_radps = min(max_turn_radps, limits.value.max_turn_radps)
        wanted = Twist(v_mps=max_speed_mps * speed_ratio, omega_radps=max_turn_radps * turn_ratio)
        twist = self._limited(self._smoothed(wanted, stamp), map.value, theta_rad, self._braking(limits.value))
        self._last = stamp, twist
        return twist

    def _smoothed(self, wanted: Twist, stamp: int) -> Twist:
        if self.smoothing_s == 0.0 or self._last is None:
            return wanted
        before, last = self._last
        kept = math.exp(-(stamp - before) * 1e-6 / self.smoothing_s)
        return Twist(
            v_mps=wanted.v_mps + kept * (last.v_mps - wanted.v_mps),
            omega_radps=wanted.omega_radps + kept * (last.omega_radps - wanted.omega_radps),
        )

    def _braking(self, limits: BaseLimits | None) -> Braking:
        """Return what to count on: what is given, else what follows from the base, else what needs no base."""
        ahead_mps2, near_mps2 = self.max_decel_mps2, None
        if ahead_mps2 is None and limits is not None:
            ahead_mps2, near_mps2 = self.decel_ratio * limits.max_decel_mps2, limits.max_decel_mps2
        reaction_s = self.reaction_s
        if reaction_s is None and limits is not None and self._delays_s:
            reaction_s = self.reaction_ratio * (max(self._delays_s) + limits.latency_s)
        return Braking(
            _UNDECLARED_DECEL_MPS2 if ahead_mps2 is None else ahead_mps2,
            near_mps2,
            _UNDECLARED_REACTION_S if reaction_s is None else reaction_s,
            self._turn_radps,
            math.inf if limits is None else limits.max_turn_accel_radps2,
        )

    def _limited(
        self,
        twist: Twist,
        map: LocalMap | None,  # noqa: A002  # the port's name
        theta_rad: float,
        braking: Braking,
    ) -> Twist:
        """Return the command at most as fast as the robot can stop within the way that the map shows free.

        The robot comes as near to obstacles as it is steered to, and not nearer because it has not turned there yet.
        """
        if map is None:
            return twist
        sign = math.copysign(1.0, twist.v_mps)
        radius_m = kept_m(map, theta_rad, 2 * self.robot_radius_m)
        if radius_m < self.robot_radius_m - self.map_error_m:
            radius_m = self.robot_radius_m
        radius_m = min(radius_m, self.robot_radius_m + _MARGIN_M)
        safe_mps = safe_speed_mps(free_way_m(map, radius_m, sign), braking.ahead_mps2, braking.reaction_s)
        v_mps = sign * min(abs(twist.v_mps), safe_mps)
        if braking.near_mps2 is not None:
            near_m = float(map.obstacle_m_at(np.zeros(1), np.zeros(1))[0]) - self.robot_radius_m
            room_m = max(near_m, 0.0) + self.map_error_m
            v_mps = sign * min(abs(v_mps), safe_speed_mps(room_m, braking.near_mps2, braking.reaction_s))
            within_m = radius_m, self.robot_radius_m + _TURNING_MARGIN_M
            v_mps = speed_around_mps(map, Twist(v_mps, twist.omega_radps), theta_rad, within_m, braking)
        return Twist(v_mps=v_mps, omega_radps=twist.omega_radps)


def free_way_m(map: LocalMap, radius_m: float, sign: float = 1.0) -> float:  # noqa: A002  # the port's name
    """Return how far a disc of ``radius_m`` drives straight on before it meets an obstacle or unknown floor, metres.

    ``sign``: 1 forward, -1 backward.

    Where the disc is in touch already, only a nearer touch ends the way.
    """
    steps_m = map.cell_m / 2 * np.arange(max(map.state.shape))
    aside_m = np.zeros_like(steps_m)
    near_m, unknown_m = map.obstacle_m_at(sign * steps_m, aside_m), map.unknown_m_at(sign * steps_m, aside_m)
    blocked = near_m < min(radius_m, float(near_m[0]) - TOLERANCE_M)
    blocked |= unknown_m <= 0.0
    return float(steps_m[max(int(np.argmax(blocked)) - 1, 0)]) if blocked.any() else float(steps_m[-1])


def speed_around_mps(
    map: LocalMap,  # noqa: A002  # the port's name
    twist: Twist,
    theta_rad: float,
    within_m: tuple[float, float],
    braking: Braking,
) -> float:
    """Return the highest of ten shares of a speed from which a disc that turns stops on its way, m/s.

    In time to come no nearer to obstacles than the straight way at ``theta_rad`` from forward does up to the same
    distance, between the two of ``within_m``, or than it is; 0 if none does. It drives on with the turning rate that it
    has until it has got to the one of ``twist``. A slower disc drives a tighter arc. What comes after a quarter of a
    turn is not asked.
    """
    speeds_mps = abs(twist.v_mps) * _SHARES
    more_radps = braking.turn_radps - twist.omega_radps
    if abs(twist.v_mps) < _STILL or max(abs(more_radps), abs(twist.omega_radps)) < _STILL:
        return twist.v_mps
    stops_m = speeds_mps * braking.reaction_s + speeds_mps**2 / (2 * braking.ahead_mps2)
    step_m = map.cell_m / 2
    steps_m = step_m * np.arange(min(math.ceil(2 * stops_m[0] / map.cell_m) + 1, max(map.state.shape)))
    sign = math.copysign(1.0, twist.v_mps)
    times_s = steps_m / speeds_mps[:, None]
    ends_s = max(abs(more_radps) / braking.turn_radps2, _STILL)
    slowing_s = np.minimum(times_s, ends_s)
    turned_rad = twist.omega_radps * times_s + more_radps * (slowing_s - slowing_s**2 / (2 * ends_s))
    middle_rad = (turned_rad[:, 1:] + turned_rad[:, :-1]) / 2
    forward_m, left_m = np.zeros_like(turned_rad), np.zeros_like(turned_rad)
    np.cumsum(sign * step_m * np.cos(middle_rad), axis=1, out=forward_m[:, 1:])
    np.cumsum(sign * step_m * np.sin(middle_rad), axis=1, out=left_m[:, 1:])
    near_m = map.obstacle_m_at(forward_m, left_m)
    straight_m = map.obstacle_m_at(math.cos(theta_rad) * steps_m, math.sin(theta_rad) * steps_m)
    limit_m = np.clip(np.minimum.accumulate(straight_m) - TOLERANCE_M, *within_m)
    blocked = near_m < np.minimum(limit_m, float(near_m[0, 0]) - TOLERANCE_M)
    stops = ~(blocked & (np.abs(turned_rad) <= math.pi / 2) & (steps_m <= stops_m[:, None])).any(axis=1)
    return sign * float(speeds_mps[np.argmax(stops)]) if stops.any() else 0.0


def turned_radps(before_radps: float, wanted_radps: float, limits: BaseLimits | None, elapsed_s: float) -> float:
    """Return the turning rate that a base has got to after a while, rad/s: the wanted one if it declares nothing."""
    if limits is None:
        return wanted_radps
    reach_radps = limits.max_turn_accel_radps2 * elapsed_s
    return before_radps + min(max(wanted_radps - before_radps, -reach_radps), reach_radps)


def kept_m(map: LocalMap, theta_rad: float, way_m: float) -> float:  # noqa: A002  # the port's name
    """Return how far from obstacles the robot stays on a straight way at ``theta_rad`` from forward, metres."""
    steps_m = map.cell_m / 2 * np.arange(math.ceil(2 * way_m / map.cell_m) + 1)
    forward_m, left_m = np.multiply.outer([math.cos(theta_rad), math.sin(theta_rad)], steps_m)
    return float(map.obstacle_m_at(forward_m, left_m).min())


def safe_speed_mps(way_m: float, max_decel_mps2: float, reaction_s: float) -> float:
    """Return the speed from which a robot that reacts after ``reaction_s`` stops within ``way_m``, m/s."""
    waste_mps = max_decel_mps2 * reaction_s
    return max(0.0, math.sqrt(waste_mps**2 + 2 * max_decel_mps2 * max(way_m, 0.0)) - waste_mps)
