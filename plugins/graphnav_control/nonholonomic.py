"""The control law of [OI] for a robot that cannot drive sideways."""

from __future__ import annotations

import math

from graphnav import Continuity, Latest, LocalMap, ParamError, Stage, Stamp, Steering, Twist, param
from graphnav_control.free_way import free_way_m, kept_m, safe_speed_mps

_MARGIN_M = 0.02
"""Distance to keep from obstacles, beyond the radius, where the steering does."""


class Nonholonomic(Stage):
    """Speeds of a unicycle from the direction of the control force.

    T = T_m cos(theta) and R = R_m sin(theta) [OI, section 3], T the forward speed and R the turning rate. Beyond a
    right angle the law as published would drive backwards, blind, and turn more slowly the larger the angle: there T is
    0 and R keeps its full value, so that the robot turns on the spot. ``reversing`` is the law as published.

    ``floor_ratio``, ``smoothing_s`` and ``map`` are departures from [OI], off by default. With a local map the robot
    drives no faster than it can stop before the first obstacle or unknown floor ahead; the newest map counts, however
    old it is.

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
    max_decel_mps2: float = param(0.5, gt=0.0, le=100.0, doc="deceleration to count on where a map limits the speed")
    reaction_s: float = param(
        0.25,
        ge=0.0,
        le=60.0,
        doc="time from what the camera sees to the brakes, where a map limits the speed: images and latency",
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
        self._continuity = Continuity()

    def step(self, steering: Steering, map: Latest[LocalMap], stamp: Stamp) -> Twist:  # noqa: A002  # the port's name
        """Return the command; the low-pass restarts after a gap of more than 3 periods."""
        if self._continuity.breaks(stamp):
            self._last = None
        theta_rad = steering.theta_rad
        speed_ratio, turn_ratio = math.cos(theta_rad), math.sin(theta_rad)
        if not self.reversing:
            speed_ratio = max(speed_ratio, self.floor_ratio)
            turn_ratio = turn_ratio if abs(theta_rad) <= math.pi / 2 else math.copysign(1.0, theta_rad)
        wanted = Twist(v_mps=self.max_speed_mps * speed_ratio, omega_radps=self.max_turn_radps * turn_ratio)
        twist = self._limited(self._smoothed(wanted, stamp), map.value, theta_rad)
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

    def _limited(self, twist: Twist, map: LocalMap | None, theta_rad: float) -> Twist:  # noqa: A002  # the port's name
        """Return the command at most as fast as the robot can stop within the way that the map shows free.

        The robot comes as near to obstacles as it is steered to, and not nearer because it has not turned there yet.
        """
        if map is None:
            return twist
        sign = math.copysign(1.0, twist.v_mps)
        radius_m = kept_m(map, theta_rad, 2 * self.robot_radius_m)
        if radius_m < self.robot_radius_m - self.map_error_m:
            radius_m = self.robot_radius_m
        way_m = free_way_m(map, min(radius_m, self.robot_radius_m + _MARGIN_M), sign)
        safe_mps = safe_speed_mps(way_m, self.max_decel_mps2, self.reaction_s)
        return Twist(v_mps=sign * min(abs(twist.v_mps), safe_mps), omega_radps=twist.omega_radps)
