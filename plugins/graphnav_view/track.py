"""The robot's true path, gathered from its states."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graphnav import State
from graphnav.arrays import Doubles
from graphnav_view.signals import Signals


@dataclass(frozen=True)
class Track:
    """The path of the robot.

    ``time_s`` (n,); ``pose`` (n, 3), x_m, y_m, yaw_rad; ``clearance_m`` the minimum after the first metre driven and
    in contact, None before; ``moving`` (n, m, 3), poses of the moving obstacles; ``last`` the last state.
    """

    time_s: Doubles
    pose: Doubles
    clearance_m: float | None
    moving: Doubles
    last: State

    @property
    def length_m(self) -> float:
        """Length of the path."""
        return float(_driven_m(self.pose)[-1])


def is_placed(state: State) -> bool:
    """Whether the poses of the robot and of the moving obstacles are finite, so that they can be drawn."""
    return bool(np.isfinite((state.x_m, state.y_m, state.yaw_rad)).all() and np.isfinite(state.moving).all())


def track_of(signals: Signals) -> Track | None:
    """Return the path of a recorded robot, None if the log has no states; states that are not finite are omitted."""
    states = [(utime, state) for utime, state in signals.all(State) if is_placed(state)]
    if not states:
        return None
    pose = np.array([(s.x_m, s.y_m, s.yaw_rad) for _, s in states])
    driven_m = _driven_m(pose)
    counted = (s for (_, s), m in zip(states, driven_m, strict=True) if s.contact or m >= State.UNDER_WAY_M)
    return Track(
        time_s=np.array([utime - signals.begin_us for utime, _ in states]) / 1e6,
        pose=pose,
        clearance_m=min((s.clearance_m for s in counted), default=None),
        moving=np.array([s.moving for _, s in states]).reshape(len(states), -1, 3),
        last=states[-1][1],
    )


def _driven_m(pose: Doubles) -> Doubles:
    """Return the length of the path up to each of its poses."""
    return np.concatenate([[0.0], np.hypot(*np.diff(pose[:, :2], axis=0).T).cumsum()])
