"""Motion that odometry tells late."""

from __future__ import annotations

from collections import deque

from graphnav_world.odometry import Axes
from graphnav_world.vehicle import Pose


class LateMotion:
    """Displacements from frame to frame, each given this many frames later; standstill before the first."""

    def __init__(self, frames: int) -> None:
        self._frames = frames
        self._waiting: deque[tuple[Axes, int]] = deque()

    def next(self, moved: Axes, interval_us: int) -> tuple[Axes, int]:
        """Add the displacement of the interval that ends now; return the late one, with the length of its interval."""
        self._waiting.append((moved, interval_us))
        if len(self._waiting) > self._frames:
            return self._waiting.popleft()
        return (0.0, 0.0, 0.0), interval_us


class LatePoses:
    """Poses that are read late: of each time the newest one that is old enough, from the start pose on.

    ``delay_us``: how old at least.
    """

    def __init__(self, start: Pose, delay_us: int) -> None:
        self._delay_us = delay_us
        self._read: deque[tuple[int, Pose]] = deque([(0, start)])

    def next(self, now: Pose, time_us: int) -> tuple[Pose, int]:
        """Add the pose at a time; return the late one, and its own time."""
        self._read.append((time_us, now))
        while len(self._read) > 1 and self._read[1][0] <= time_us - self._delay_us:
            self._read.popleft()
        then_us, pose = self._read[0]
        return pose, then_us
