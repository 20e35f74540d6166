"""What moves the robot, where it is and what it drives through.

Frames: W world, R robot (x forward, y left). Counterclockwise is positive.
"""

from __future__ import annotations

from typing import ClassVar

import graphnav_lcm

from graphnav.arrays import Bytes, Doubles, Ints
from graphnav.messages.message import Message


class Steering(Message, lcm=graphnav_lcm.steering_t):
    """The forces that steer, on the image's axes (right, forward), and the direction that they ask for.

    ``control`` = ``repulsive`` + ``guiding`` [OI, eq. 9]. ``theta_rad``: its angle from forward, left positive
    [OI, eq. 10, with a sign]. ``eigenvalues``: of the gradients' covariance, largest first.
    """

    repulsive: Doubles
    guiding: Doubles
    control: Doubles
    theta_rad: float
    eigenvalues: Doubles


class Twist(Message, lcm=graphnav_lcm.twist_t):
    """A command: forward speed and turning rate (counterclockwise)."""

    v_mps: float
    omega_radps: float


class Motion(Message, lcm=graphnav_lcm.motion_t):
    """Displacement since the last frame, in the robot's frame of then, as odometry sees it."""

    forward_m: float
    left_m: float
    turn_rad: float
    interval_us: int


class Odometry(Message, lcm=graphnav_lcm.odometry_t):
    """Pose and speeds as a robot's odometry sees them, at its own stamps and rate.

    ``x_m``, ``y_m``, ``yaw_rad``: in the odometry's own frame, whose origin is where it began to count. ``v_mps``:
    forward. ``omega_radps``: counterclockwise.
    """

    x_m: float
    y_m: float
    yaw_rad: float
    v_mps: float
    omega_radps: float


class Stop(Message, lcm=graphnav_lcm.stop_t):
    """Stop the robot (``engaged``), or arm it again; ``reason`` is for people.

    Every program may send it on one channel: a stop is never refused because another one sent before.
    """

    many_writers: ClassVar[bool] = True

    engaged: bool
    reason: str = ""


class GuardState(Message, lcm=graphnav_lcm.guard_state_t):
    """What the guard before the motors lets through, and why not.

    ``may_move``: whether any motion is let through; ``may_advance``: whether motion forward is. ``overridden``: an
    override drives. ``stopped``: a stop was asked for and the guard was not armed again since.

    ``causes``, ``ports``, ``values``, ``limits``: one entry for each cause that forbids something now, or would if no
    override drove: "waiting" (no message yet), "stale", "fault" (of the sender's stamps, or a value that is not
    finite), "blind", "obstacle" or "stop"; the guard's input port that it is about; what was found and what is allowed
    (seconds for waiting and stale; for blind a ratio of a plane or gray levels of an image; a ratio for obstacle; else
    0).
    """

    may_move: bool
    may_advance: bool
    overridden: bool
    stopped: bool
    causes: tuple[str, ...]
    ports: tuple[str, ...]
    values: Doubles
    limits: Doubles


class State(Message, lcm=graphnav_lcm.state_t):
    """Where the simulated robot really is; for scores and oracles only.

    ``clearance_m``: from the robot's rim to the nearest wall or obstacle, the least since the last state;
    1000 m where there is nothing.
    ``moving``: float64 (n, 3), poses (x_m, y_m, yaw_rad) of the moving obstacles in the map's order.
    """

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
    """The goal as a beacon's sensor gives it: ``bearing_rad`` from forward, left positive."""

    bearing_rad: float
    distance_m: float


class Map(Message, lcm=graphnav_lcm.map_t):
    """The world from above, published once; for scores, oracles and pictures only.

    ``kind``: uint8 (bodies,), 0 wall, 1 obstacle, 2 moving obstacle. ``height_m``: float64 (bodies,).
    ``vertices_m``: float64 (vertices, 2), outlines in W (of moving ones in their own frame). ``body``: int32
    (vertices,), ascending. ``start``: float64 (3,), x_m, y_m, yaw_rad. ``goal_m``: float64 (n, 2), outline of the
    goal region, empty if there is none. ``shortest_m``: length of the shortest path for this robot, 0 without
    a goal. ``footprint_m``: float64 (n, 2) in R, outline on the floor of what the camera sees.
    """

    kind: Bytes
    height_m: Doubles
    vertices_m: Doubles
    body: Ints
    start: Doubles
    goal_m: Doubles
    robot_radius_m: float
    shortest_m: float
    footprint_m: Doubles
