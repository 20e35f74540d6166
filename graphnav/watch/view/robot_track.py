"""The robot's path: its published poses, thinned to a bounded number."""

from __future__ import annotations

import math

import graphnav_lcm

from graphnav.core.codec import DecodeError
from graphnav.watch.channel_account import Kind
from graphnav.watch.feed import Received

_RANKS: dict[type, int] = {graphnav_lcm.odometry_t: 1, graphnav_lcm.state_t: 2}
"""The preference of pose types if several are published."""
_MAX_POINTS = 4000
_MAX_MOVING = 500
_MIN_STEP_M = 0.002

Pose = tuple[float, float, float]


class RobotTrack:
    """The path from one channel of poses, true states or odometry.

    ``points_m``: x and y, oldest first. ``generation`` changes whenever points are not only appended. ``rank``: true
    states are preferred to odometry.
    """

    def __init__(self, channel: str = "") -> None:
        self.channel = channel
        self.pose: Pose | None = None
        self.moving: list[Pose] = []
        self.points_m: list[tuple[float, float]] = []
        self.generation = 0
        self.rank = self._utime = 0
        self._kept_every = 1
        self._since_kept = 0

    @staticmethod
    def follows(kind: Kind) -> bool:
        """Whether messages of a type are poses."""
        return kind.lcm_class in _RANKS

    def receive(self, received: Received, kind: Kind) -> None:
        """Process a message if it is a pose."""
        rank = _RANKS.get(kind.lcm_class, 0)
        if not rank:
            return
        try:
            fields = kind.codec.decode(received.data)
        except DecodeError:
            return
        pose = (fields["x_m"], fields["y_m"], fields["yaw_rad"])
        if not all(map(math.isfinite, pose)):
            return
        if rank != self.rank or fields["utime"] < self._utime:
            self._restart(rank)
        self._utime = fields["utime"]
        self.pose = pose
        self.moving = [tuple(one) for one in fields.get("moving", ())[:_MAX_MOVING].tolist()] if rank == 2 else []
        self._append(pose[0], pose[1])

    def _restart(self, rank: int) -> None:
        """Start a new path, for another type or another run, whose timestamps restart."""
        self.rank = rank
        self.points_m = []
        self.generation += 1
        self._kept_every, self._since_kept = 1, 0

    def _append(self, x_m: float, y_m: float) -> None:
        self._since_kept += 1
        if self.points_m and (
            self._since_kept < self._kept_every
            or math.hypot(x_m - self.points_m[-1][0], y_m - self.points_m[-1][1]) < _MIN_STEP_M
        ):
            return
        self._since_kept = 0
        self.points_m.append((x_m, y_m))
        if len(self.points_m) > _MAX_POINTS:
            self.points_m = self.points_m[::2]
            self._kept_every *= 2
            self.generation += 1
