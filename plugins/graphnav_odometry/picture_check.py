"""Whether odometry moves as the picture does: both motions, compared over up to two seconds."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from graphnav import Flow, Mount, OdometryCheck, coarsen
from graphnav.arrays import Doubles
from graphnav_odometry.pose import Pose
from graphnav_odometry.track import Jump

WINDOWS_US = (600_000, 2_000_000)
"""Times over which motions are summed: a slow robot needs the longer one."""
MIN_COVERED, MIN_FRAMES = 0.75, 4
"""Share of a window that frames with a motion have to cover, and how many frames at least."""
HOLD_US = 1_000_000
"""Time for which a fault is reported after it showed last."""
MIN_MOVED_RAD = 0.05
"""Smallest turn that is compared, and smallest way in heights of the camera, about the angle by which the floor moves.

What one of the two falsely adds to the other in the fit, by obstacles, is a share of it, `_CROSS`.
"""
MOTIONLESS_RATIO, AGREES_RATIO, SCALE_RATIO = 0.2, 3.0, 10.0
"""Odometry that measures less than the first is motionless; the second agrees; more than the third is another unit."""
_CROSS, _CROSS_REVERSED = 0.3, 0.05
_MIN_SCALED_FRAMES = 3
_MIN_SHOWN_PX = 0.1
_MAX_CELLS, _MIN_CELLS = 48, 12
_ITERATIONS = 6
_MIN_SUPPORT = 0.5


class _Frame(NamedTuple):
    """The motion of a frame by odometry and by the picture: ways in heights of the camera, turns in radians.

    ``is_jump``: the measured turn is too fast to be one. Many of these are another unit, a single one is a new heading.
    """

    utime: int
    interval_us: int
    measured: Doubles
    shown: Doubles
    has_moved: bool
    is_jump: bool


class _Finding(NamedTuple):
    fault: str
    value: float
    limit: float
    axis: int | None


class PictureCheck:
    """Compares odometry with the motion of the floor in the flow, and keeps what is wrong with it.

    The flow of the floor depends on the way forward and the turn; both are fitted to all valid vectors by reweighted
    least squares. The floor need not be told from obstacles: what stands on it flows faster, but not another way, and
    the faults that are looked for are gross. Frames of which less than half agrees with the fit are not used.
    """

    def __init__(self, mount: Mount) -> None:
        self._mount = mount
        self._frames: deque[_Frame] = deque()
        self._found: _Finding | None = None
        self._found_at = 0
        self._axis: int | None = None
        self._agrees = False

    def check(self, utime: int, flow: Flow, moved: Pose | None, jump: Jump | None) -> OdometryCheck:
        """Return what is known after another frame; ``moved`` by odometry, None if that is unknown."""
        if moved is not None and (jump is None or jump.is_turn):
            self._add(utime, flow, moved, is_jump=jump is not None)
        finding = self._contradiction(utime)
        if finding is not None:
            self._frames.clear()  # what was judged is not evidence again
        elif jump is not None:
            finding = _Finding("turn_jump" if jump.is_turn else "jump", jump.size, jump.limit, None)
        if finding is not None:
            if finding.axis is not None or self._agrees:
                self._axis = finding.axis  # a jump does not excuse what was wrong before it
            self._found, self._found_at, self._agrees = finding, utime, False
        elif self._found is not None and not 0 <= utime - self._found_at < HOLD_US:
            self._found = None
        if self._found is not None:
            return OdometryCheck(
                fault=self._found.fault, value=self._found.value, limit=self._found.limit, agrees=False
            )
        self._agrees |= self._is_agreed(utime)
        return OdometryCheck(fault="", value=0.0, limit=0.0, agrees=self._agrees)

    def _add(self, utime: int, flow: Flow, moved: Pose, *, is_jump: bool) -> None:
        shown = self._shown(flow)
        while self._frames and not 0 <= utime - self._frames[0].utime < WINDOWS_US[-1]:
            self._frames.popleft()
        if shown is not None:
            midway = moved.x_m * math.cos(moved.yaw_rad / 2) + moved.y_m * math.sin(moved.yaw_rad / 2)
            measured = np.array([midway / self._mount.height_m, moved.yaw_rad])
            self._frames.append(_Frame(utime, flow.interval_us, measured, *shown, is_jump))

    def _shown(self, flow: Flow) -> tuple[Doubles, bool] | None:
        """Return the way and the turn that the picture shows and whether it moves; None if it does not show them."""
        cells = coarsen(flow, flow.step_px * max(-(-flow.valid.shape[1] // _MAX_CELLS), 1))
        valid = cells.valid.reshape(-1) != 0
        if np.count_nonzero(valid) < _MIN_CELLS:
            return None
        uv_px = cells.uv_px.reshape(-1, 2)[valid].astype(np.float64)
        fields_px = self._mount.floor_fields_px(cells)[:2, valid]
        fields_px[0] *= self._mount.height_m
        equations, measured = fields_px.reshape(2, -1).T, uv_px.reshape(-1)
        weight = np.ones(len(uv_px))
        shown = np.zeros(2)
        for _ in range(_ITERATIONS):
            weighted = equations.T * np.repeat(weight, 2)
            shown = np.linalg.solve(weighted @ equations + 1e-9 * np.eye(2), weighted @ measured)
            left_px = np.linalg.norm((measured - equations @ shown).reshape(-1, 2), axis=1)
            weight = 1.0 / (1.0 + (left_px / max(_MIN_SHOWN_PX, 1.5 * float(np.median(left_px)))) ** 2) ** 2
        length_px = np.linalg.norm(uv_px, axis=1)
        support = float(np.mean(left_px <= 0.3 + 0.3 * length_px))
        has_moved = float(np.median(length_px)) >= _MIN_SHOWN_PX
        return (np.asarray(shown), has_moved) if support >= _MIN_SUPPORT else None

    def _contradiction(self, utime: int) -> _Finding | None:
        for window_us in WINDOWS_US:
            if frames := self._window(utime, window_us):
                for axis in (1, 0):
                    if finding := _compared(frames, axis):
                        return finding
        return None

    def _is_agreed(self, utime: int) -> bool:
        axes = (0, 1) if self._axis is None else (self._axis,)
        for window_us in WINDOWS_US:
            if frames := self._window(utime, window_us):
                measured, shown = _sums(frames)
                if any(
                    abs(shown[axis]) >= _min_shown(shown, axis)
                    and shown[axis] / AGREES_RATIO <= measured[axis] * math.copysign(1.0, shown[axis])
                    and abs(measured[axis]) <= AGREES_RATIO * abs(shown[axis])
                    for axis in axes
                ):
                    return True
        return False

    def _window(self, utime: int, window_us: int) -> Sequence[_Frame]:
        """Return the frames of the last ``window_us``, none if they cover too little of it."""
        frames = [frame for frame in self._frames if utime - frame.utime < window_us]
        covered_us = sum(frame.interval_us for frame in frames)
        return frames if len(frames) >= MIN_FRAMES and covered_us >= MIN_COVERED * window_us else ()


def _sums(frames: Sequence[_Frame]) -> tuple[Doubles, Doubles]:
    measured = np.sum([frame.measured for frame in frames], axis=0)
    shown = np.sum([frame.shown for frame in frames], axis=0)
    return measured, shown


def _min_shown(shown: Doubles, axis: int, cross: float = _CROSS) -> float:
    return float(MIN_MOVED_RAD + cross * abs(shown[1 - axis]))


def _compared(frames: Sequence[_Frame], axis: int) -> _Finding | None:
    """Return the fault of way (axis 0) or turn (axis 1) in a window."""
    measured, shown = (float(sums[axis]) for sums in _sums(frames))
    floor = MIN_MOVED_RAD / SCALE_RATIO
    scaled = [
        frame
        for frame in frames
        if frame.has_moved
        and abs(frame.measured[axis]) > SCALE_RATIO * max(abs(frame.shown[axis]), floor / len(frames))
    ]
    if len(scaled) >= _MIN_SCALED_FRAMES and abs(measured) > SCALE_RATIO * max(abs(shown), floor):
        return _Finding("scale", abs(measured) / max(abs(shown), floor), SCALE_RATIO, axis)
    steady = [frame for frame in frames if not frame.is_jump]
    if len(steady) < MIN_FRAMES:
        return None
    told, both = _sums(steady)
    measured, shown = float(told[axis]), float(both[axis])
    if abs(shown) >= _min_shown(both, axis) and abs(measured) < MOTIONLESS_RATIO * abs(shown):
        return _Finding("motionless", measured / shown, MOTIONLESS_RATIO, axis)
    # Both have to be large, and against each other: a smaller share of the other motion is enough.
    is_large = min(abs(measured), abs(shown)) >= MIN_MOVED_RAD and abs(shown) >= _min_shown(both, axis, _CROSS_REVERSED)
    return _Finding("reversed", measured / shown, 0.0, axis) if is_large and measured * shown < 0.0 else None
