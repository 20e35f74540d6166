"""Select the most informative frame of a run, and read its messages."""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import median
from typing import NamedTuple

import numpy as np

from graphnav import Flow, Image, LocalMap, Plane, Potential, State, Steering
from graphnav_view.signals import Signals

MIN_RATIO, MAX_RATIO = 0.03, 0.5
"""Shares of obstacle at which a picture shows both obstacle and ground, as the method assumes."""

MAX_SPIN_RADPS = 0.05
"""Maximum turning rate of nearly straight driving."""

MIN_SPEED_RATIO = 0.9
"""Share of the median speed from which on a robot drives, or a picture moves: a robot at rest shows no motion."""


@dataclass(frozen=True)
class Frame:
    """The messages of one stamp in a log; None for missing ones."""

    utime: int
    image: Image | None
    flow: Flow | None
    plane: Plane | None
    potential: Potential | None
    steering: Steering | None
    state: State | None
    time_s: float = 0.0
    """From the start of the log."""
    local_map: LocalMap | None = None

    @property
    def shape_px(self) -> tuple[int, int]:
        """Rows and columns of the picture, in its own pixels."""
        if self.image is not None:
            rows, cols = self.image.pixels.shape[:2]
            return rows * self.image.step_px, cols * self.image.step_px
        for grid, rows_of in ((self.flow, "uv_px"), (self.plane, "obstacle"), (self.potential, "potential")):
            if grid is not None:
                rows, cols = getattr(grid, rows_of).shape[:2]
                return rows * grid.step_px, cols * grid.step_px
        return 3, 4


class _Glance(NamedTuple):
    """The criteria for a keyframe; turn, push, spin and speed are absolute values.

    ``speed``: of the robot, m/s; in a log without its state the mean length of the flow, pixels per frame.
    """

    utime: int
    judged_ratio: float
    obstacle_ratio: float
    turn_rad: float
    push: float
    spin_radps: float
    speed: float


def _glance(utime: int, plane: Plane, steering: Steering | None, moves: State | Flow | None) -> _Glance:
    state = moves if isinstance(moves, State) else None
    return _Glance(
        utime,
        float((plane.valid != 0).mean()),
        plane.obstacle_ratio,
        0.0 if steering is None else abs(steering.theta_rad),
        0.0 if steering is None else abs(float(steering.repulsive[0])),
        0.0 if state is None else abs(state.omega_radps),
        _mean_px(moves) if isinstance(moves, Flow) else 0.0 if state is None else abs(state.v_mps),
    )


def _mean_px(flow: Flow) -> float:
    valid = flow.valid != 0
    return float(np.linalg.norm(flow.uv_px[valid], axis=1).mean()) if valid.any() else 0.0


def keyframe_utime(signals: Signals) -> int | None:
    """Return the stamp of the frame to show, None if the log has no camera data.

    Among the frames whose share of obstacle lies between 3 and 50 %, and whose theta is at most a right angle, at which
    the robot still drives: the one with the largest sideways component of the repulsive force (to a hundredth; the
    earliest of equals). Theta itself would favour frames in which the forces nearly cancel. Frames in which the robot
    still drives nearly straight are preferred: they show the cause of a turn, not its effect.

    Without such a frame, the one whose share is nearest to a quarter, among those in which the robot drives. In either
    case frames with fewer judged cells than 0.9 of the median frame do not count, nor do, in a log without the robot's
    state, those in which the picture hardly moves. Without a plane, the middle frame of the flow, else of the images.
    """
    has_state = bool(signals.stamps(State))
    glances = [
        _glance(utime, plane, steering, moves)
        for utime, (plane, steering, moves) in signals.joined(Plane, Steering, State if has_state else Flow)
    ]
    if not has_state:  # without a flow it is not known whether the picture moved
        glances = [glance for glance in glances if glance.speed > 0.0] or glances
    if glances:
        enough = 0.9 * median(glance.judged_ratio for glance in glances)
        seen = [glance for glance in glances if glance.judged_ratio >= enough]
        usual = MIN_SPEED_RATIO * median(glance.speed for glance in seen)
        driven = [glance for glance in seen if glance.speed >= usual]
        if not has_state:
            seen = driven
        shared = [g for g in seen if MIN_RATIO <= g.obstacle_ratio <= MAX_RATIO and g.turn_rad <= math.pi / 2]
        if shared:
            straight = [glance for glance in shared if glance.spin_radps <= MAX_SPIN_RADPS]
            return max(straight or shared, key=lambda g: (round(g.push, 2), -g.utime)).utime
        return min(driven or seen, key=lambda g: (round(abs(g.obstacle_ratio - 0.25), 3), g.utime)).utime
    for kind in (Flow, Image):
        stamps = signals.stamps(kind)
        if stamps:
            return stamps[len(stamps) // 2]
    return None


def frame_at(signals: Signals, utime: int) -> Frame:
    """Return the messages of one stamp."""
    return Frame(
        utime=utime,
        image=signals.at(Image, utime),
        flow=signals.at(Flow, utime),
        plane=signals.at(Plane, utime),
        potential=signals.at(Potential, utime),
        steering=signals.at(Steering, utime),
        state=signals.at(State, utime),
        time_s=(utime - signals.begin_us) / 1e6,
        local_map=signals.at(LocalMap, utime),
    )


def frame_texts(frame: Frame) -> list[str]:
    """Return the share of obstacle and the steering angle of a frame, for its headline."""
    words = [] if frame.plane is None else [f"obstacle {frame.plane.obstacle_ratio:.0%}"]
    return words if frame.steering is None else [*words, f"θ = {theta_text(frame.steering.theta_rad)}"]


def theta_text(theta_rad: float) -> str:
    """Return a steering angle in degrees, with the side."""
    degrees = round(math.degrees(theta_rad))
    return "0°" if degrees == 0 else f"{abs(degrees)}° {'left' if degrees > 0 else 'right'}"


def from_forward(theta_rad: float) -> str:
    """Return a steering angle as part of a sentence."""
    text = theta_text(theta_rad)
    return "0°, straight forward" if text == "0°" else f"{text} of forward"
