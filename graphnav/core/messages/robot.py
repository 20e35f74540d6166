"""Messages about the robot and its world: commands, limits of the base, motion, odometry, state, goal, map.

Frames: W world, R robot (x forward, y left). Counterclockwise is positive.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar, Self

import graphnav_lcm
import numpy as np

from graphnav.arrays import Bytes, Doubles, Indices, Ints
from graphnav.core.messages.message import FieldError, Message


class Steering(Message, lcm=graphnav_lcm.steering_t):
    """The steering forces on the image's axes (right, forward), and the resulting direction.

    ``control`` = ``repulsive`` + ``guiding`` [OI, eq. 9]. ``theta_rad``: its angle from forward, left positive
    [OI, eq. 10, with a sign]. ``eigenvalues``: of the gradients' covariance, largest first.
    """

    repulsive: Doubles
    guiding: Doubles
    control: Doubles
    theta_rad: float
    eigenvalues: Doubles


class Twist(Message, lcm=graphnav_lcm.twist_t):
    """A velocity command: forward speed and turning rate (counterclockwise)."""

    v_mps: float
    omega_radps: float


class BaseLimits(Message, lcm=graphnav_lcm.base_limits_t):
    """Capabilities of a robot's base, as its driver declares them; published once, or repeated for late subscribers.

    ``max_speed_mps``: forwards and backwards. ``max_turn_radps``: to either side. ``max_accel_mps2``,
    ``max_turn_accel_radps2``: up to these speeds. ``max_decel_mps2``: with which the base surely brakes when it is told
    to stop. ``latency_s``: longest time from the arrival of a command to the beginning of its effect.
    """

    max_speed_mps: float
    max_turn_radps: float
    max_accel_mps2: float
    max_decel_mps2: float
    max_turn_accel_radps2: float
    latency_s: float

    @classmethod
    def from_lcm_fields(cls, values: Mapping[str, Any]) -> Self:
        """Return the limits of ``base_limits_t``.

        Raises
        ------
        FieldError
            A speed or an acceleration is not above 0, or the latency is below 0.
        """
        found = super().from_lcm_fields(values)
        for name in cls._names:
            value = getattr(found, name)
            if name == "latency_s" and value < 0.0:
                raise FieldError(name, f"{value:g}", "0 or more")
            if name != "latency_s" and not value > 0.0:
                raise FieldError(name, f"{value:g}", "more than 0")
        return found


class Motion(Message, lcm=graphnav_lcm.motion_t):
    """Displacement since the last frame, in the robot frame at that time, measured by odometry."""

    forward_m: float
    left_m: float
    turn_rad: float
    interval_us: int


class Odometry(Message, lcm=graphnav_lcm.odometry_t):
    """Pose and speeds measured by a robot's odometry, at its own timestamps and rate.

    ``x_m``, ``y_m``, ``yaw_rad``: in the odometry frame, whose origin is the pose at its start. ``v_mps``:
    forward. ``omega_radps``: counterclockwise.
    """

    x_m: float
    y_m: float
    yaw_rad: float
    v_mps: float
    omega_radps: float


class OdometryCheck(Message, lcm=graphnav_lcm.odometry_check_t):
    """Whether odometry agrees with the motion that the picture shows.

    ``fault``: "" or why odometry is not used: "jump" or "turn_jump" (between two samples), "motionless" (the picture
    moves, odometry does not), "reversed" (it moves the other way) or "scale" (it moves by far more, as degrees read as
    radians do). ``value``, ``limit``: metres for a jump, radians for a turn_jump, else the motion by odometry as a
    multiple of the motion that the picture shows. ``agrees``: whether it has agreed with a picture that moved, in what
    was at fault before.
    """

    fault: str
    value: float
    limit: float
    agrees: bool


class Stop(Message, lcm=graphnav_lcm.stop_t):
    """Stop the robot (``engaged``), or arm it again; ``reason`` is shown to users.

    Any program may send it: a stop is never rejected because another program has sent one before.
    """

    many_writers: ClassVar[bool] = True

    engaged: bool
    reason: str = ""


_UNITS = {"waiting": "s", "stale": "s", "frozen": "px", "jump": "m", "turn_jump": "rad"}
"""Units of what a guard measures, by the cause; ratios have none."""
_CONTRADICTIONS = {"frozen", "jump", "turn_jump", "motionless", "reversed", "scale"}
"""Causes that an input contradicts the robot's motion, or that of the picture."""


class GuardState(Message, lcm=graphnav_lcm.guard_state_t):
    """The decision of the guard before the motors, and its causes.

    ``may_move``: whether any motion is allowed; ``may_advance``: whether forward motion is. ``overridden``: an override
    is active. ``stopped``: a stop was requested, or a frozen picture, faulty odometry or flow that was not known again
    and again holds the robot for good, and the guard was not armed again since. A "frozen" or a fault of odometry that
    forbids no motion although no override is active is being retried (`is_retrying`).

    ``causes``, ``ports``, ``values``, ``limits``: one entry for each cause that restricts motion now, or would
    without the override: "waiting" (no message yet), "stale", "fault" (of the sender's timestamps, or a value that is
    not finite), "blind", "unknown" (cells that were not judged), "confused" (flow that is not known well), "obstacle",
    "frozen" (a picture that does not move while the robot does), a fault of `OdometryCheck` or "stop"; the guard's
    input port; the measured value and its limit (seconds for waiting and stale; for blind a ratio of a plane or gray
    levels of an image; a ratio for unknown, confused and obstacle; pixels for frozen; those of the check for odometry;
    else 0).
    """

    may_move: bool
    may_advance: bool
    overridden: bool
    stopped: bool
    causes: tuple[str, ...]
    ports: tuple[str, ...]
    values: Doubles
    limits: Doubles

    @staticmethod
    def unit(cause: str, port: str) -> str:
        """Return the unit of a cause's value and limit, empty if they have none; ``port``: the guard's input."""
        return "gray levels" if (cause, port) == ("blind", "image") else _UNITS.get(cause, "")

    @staticmethod
    def is_contradiction(cause: str) -> bool:
        """Whether a cause is that an input contradicts the motion of the robot: "frozen", or a fault of odometry."""
        return cause in _CONTRADICTIONS

    @property
    def is_retrying(self) -> bool:
        """Whether the robot moves, slowly, to see whether an input that contradicts its motion follows it again."""
        return self.may_move and not self.overridden and any(map(self.is_contradiction, self.causes))

    def described(self) -> list[str]:
        """Return each cause with its input, its value and the limit, such as "stale: image, 1.2 s (limit 0.5 s)"."""
        texts = []
        for cause, port, value, limit in zip(self.causes, self.ports, self.values, self.limits, strict=True):
            unit = f" {self.unit(cause, port)}".rstrip()
            found = f", {value:.3g}{unit} (limit {limit:.3g}{unit})" if value or limit else ""
            texts.append(f"{cause}: {port}{found}")
        return texts


class RecoveryState(Message, lcm=graphnav_lcm.recovery_state_t):
    """State of the recovery of a robot that turns on one place and does not get on.

    ``doing``: "" while it gets on, "look_again", "other_way" or "back_out". ``recoveries``: how many have begun since
    the start; as this grows, a map forgets obstacles that fewer full frames than ``doubt`` have shown. ``turned_rad``:
    how far the robot has turned, to either side, on the place where it is.
    """

    doing: str
    recoveries: int
    turned_rad: float
    doubt: float


class State(Message, lcm=graphnav_lcm.state_t):
    """The true state of the simulated robot; for scores and oracles only.

    ``clearance_m``: minimum distance since the last state from the robot's rim to a wall or obstacle; 1000 m if there
    is none.
    ``moving``: float64 (n, 3), poses (x_m, y_m, yaw_rad) of the moving obstacles in the map's order.
    """

    is_truth: ClassVar[bool] = True
    UNDER_WAY_M: ClassVar[float] = 1.0
    """Length of the path from which on scores and pictures tell the minimum clearance of a drive: before, what is
    nearest stands around the start."""

    x_m: float
    y_m: float
    yaw_rad: float
    v_mps: float
    omega_radps: float
    clearance_m: float
    contact: bool
    at_goal: bool
    moving: Doubles


class Goal(Message, lcm=graphnav_lcm.goal_t):
    """The direction of the goal, as from a beacon sensor: ``bearing_rad`` from forward, left positive."""

    bearing_rad: float
    distance_m: float


class Map(Message, lcm=graphnav_lcm.map_t):
    """The world in top view, published once; for scores, oracles and pictures only.

    ``kind``: uint8 (bodies,), 0 wall, 1 obstacle, 2 moving obstacle, 3 the robot itself. ``height_m``: float64
    (bodies,). ``vertices_m``: float64 (vertices, 2), outlines in W (moving ones in their own frame). ``body``: int32
    (vertices,), ascending. ``start``: float64 (3,), x_m, y_m, yaw_rad. ``goal_m``: float64 (n, 2), outline of the
    goal region, empty if there is none. ``shortest_m``: length of the shortest path for this robot, 0 without
    a goal. ``footprint_m``: float64 (n, 2) in R, outline on the floor of what the camera sees.

    A robot that is not a disc is the last body, its outline in R; ``robot_radius_m`` is then that of the circle around
    it. What reads the bodies as what surrounds the robot takes `surroundings`.
    """

    is_truth: ClassVar[bool] = True
    WALL: ClassVar[int] = 0
    OBSTACLE: ClassVar[int] = 1
    MOVING: ClassVar[int] = 2
    ROBOT: ClassVar[int] = 3
    """The values of ``kind``."""

    kind: Bytes
    height_m: Doubles
    vertices_m: Doubles
    body: Ints
    start: Doubles
    goal_m: Doubles
    robot_radius_m: float
    shortest_m: float
    footprint_m: Doubles

    @property
    def robot_outline_m(self) -> Doubles | None:
        """The outline of the robot in R, (n, 2), counterclockwise; None for a disc of ``robot_radius_m``."""
        robots = np.flatnonzero(self.kind == Map.ROBOT)
        return self.vertices_m[self.body == robots[0]] if len(robots) else None

    def surroundings(self) -> Map:
        """Return the map without the robot's own outline: itself for a disc."""
        bodies = np.flatnonzero(self.kind != Map.ROBOT)
        if len(bodies) == len(self.kind):
            return self
        kept = self.body < len(bodies)  # the robot comes last
        return replace(
            self,
            kind=self.kind[bodies],
            height_m=self.height_m[bodies],
            vertices_m=self.vertices_m[kept],
            body=self.body[kept],
        )

    def next_vertices(self) -> Indices:
        """Return the index of the vertex after each one around its body, (vertices,)."""
        following = np.arange(len(self.body)) + 1
        starts = np.flatnonzero(np.diff(self.body, prepend=-1))
        ends = np.append(starts[1:], len(self.body))[: len(starts)] - 1
        following[ends] = starts
        return following
