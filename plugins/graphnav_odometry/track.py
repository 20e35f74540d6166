"""Recent odometry of a robot: ordered samples, and the pose at any time between them."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from itertools import pairwise
from statistics import median
from typing import NamedTuple

from graphnav import Odometry
from graphnav_odometry.pose import Pose, arc, part_of_arc

MAX_PERIODS = 3.0
"""Longest gap, in typical periods, that is interpolated."""
KEPT_US = 1_000_000
"""Samples of this time before the last frame determine the typical period; older ones are dropped."""
MAX_SAMPLES = 4096
"""Maximum number of samples, at any rate of the sender."""


class Jump(NamedTuple):
    """A step between two samples that is not a motion, and the longest that would be one: metres, else radians."""

    size: float
    limit: float
    is_turn: bool


class Track:
    """Samples of odometry, oldest first, with headings that are not wrapped.

    Parameters
    ----------
    max_speed_mps, max_turn_radps
        Faster changes between two samples are not motion: the odometry was reset.
    """

    def __init__(self, max_speed_mps: float, max_turn_radps: float) -> None:
        self._max_speed_mps, self._max_turn_radps = max_speed_mps, max_turn_radps
        self._stamps: list[int] = []
        self._samples: list[Odometry] = []
        self._poses: list[Pose] = []

    def add(self, utime: int, sample: Odometry) -> None:
        """Add the next sample; one that is not newer than the last is dropped.

        If it is older than the last by more than a second, the sender's clock was set back and the track restarts.
        """
        if self._stamps and utime <= self._stamps[-1]:
            if self._stamps[-1] - utime <= KEPT_US:
                return
            self._drop(len(self._stamps))
        yaw_rad = sample.yaw_rad
        if self._poses:
            last_rad = self._poses[-1].yaw_rad
            yaw_rad = last_rad + math.remainder(yaw_rad - last_rad, 2 * math.pi)
        self._stamps.append(utime)
        self._samples.append(sample)
        self._poses.append(Pose(sample.x_m, sample.y_m, yaw_rad))
        if len(self._stamps) > MAX_SAMPLES:
            self._drop(len(self._stamps) - MAX_SAMPLES // 2)

    def forget_before(self, utime: int) -> None:
        """Drop samples older than ``utime`` by more than a second, except the newest of these."""
        self._drop(bisect_right(self._stamps, utime - KEPT_US) - 1)

    def moved(self, begin: int, end: int, max_extrapolation_us: float) -> Pose | None:
        """Return the pose at stamp ``end`` in the frame of the pose at ``begin``, None if unknown; over jumps, too.

        ``max_extrapolation_us``: maximum extrapolation beyond the last sample.
        """
        if len(self._stamps) < 2 or begin < self._stamps[0] or end > self._stamps[-1] + max_extrapolation_us:
            return None
        usual_us = self._usual_us()
        steps = self._steps(begin, end)
        if any(self._stamps[k + 1] - self._stamps[k] > MAX_PERIODS * usual_us for k in steps):
            return None
        return self._at(end).seen_from(self._at(begin))

    def jump(self, begin: int, end: int) -> Jump | None:
        """Return the first jump between the samples around ``begin`` and ``end``, one of a position before a turn."""
        usual_us = self._usual_us() if len(self._stamps) > 1 else 0.0
        turn = None
        for k in self._steps(begin, end):
            # Jitter of stamps must not turn a small step into a jump.
            elapsed_s = max(self._stamps[k + 1] - self._stamps[k], usual_us / 2) * 1e-6
            step = self._poses[k + 1].seen_from(self._poses[k])
            distance_m, max_m = math.hypot(step.x_m, step.y_m), self._max_speed_mps * elapsed_s
            if distance_m > max_m:
                return Jump(distance_m, max_m, is_turn=False)
            if turn is None and abs(step.yaw_rad) > self._max_turn_radps * elapsed_s:
                turn = Jump(abs(step.yaw_rad), self._max_turn_radps * elapsed_s, is_turn=True)
        return turn

    def _usual_us(self) -> float:
        """Return the typical period of two samples and more."""
        return median(after - before for before, after in pairwise(self._stamps))

    def _steps(self, begin: int, end: int) -> range:
        """Return the indices of the samples before the steps that make the motion from ``begin`` to ``end``."""
        first, last = bisect_right(self._stamps, begin) - 1, bisect_left(self._stamps, end)
        return range(max(first, 0), min(last, len(self._stamps) - 1))

    def _at(self, utime: int) -> Pose:
        """Return the pose at a stamp: on the arc between two samples, or extrapolated beyond the last one."""
        after = bisect_left(self._stamps, utime)
        if after == len(self._stamps):
            sample, elapsed_s = self._samples[-1], (utime - self._stamps[-1]) * 1e-6
            return self._poses[-1].then(arc(sample.v_mps * elapsed_s, 0.0, sample.omega_radps * elapsed_s))
        if self._stamps[after] == utime:
            return self._poses[after]
        before = after - 1
        share = (utime - self._stamps[before]) / (self._stamps[after] - self._stamps[before])
        return self._poses[before].then(part_of_arc(self._poses[after].seen_from(self._poses[before]), share))

    def _drop(self, count: int) -> None:
        if count > 0:
            del self._stamps[:count], self._samples[:count], self._poses[:count]
