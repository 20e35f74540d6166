"""How a drive went: success, safety, length, time, smoothness."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

from graphnav import UNDEFINED, Latest, Map, Metric, Stage, Stamp, State, param

NOTHING_NEAR_M = 1000.0
"""The clearance that `State` gives where there is nothing."""

Pair = tuple[float, float]


class Navigation(Stage):
    """How a drive went.

    Without a goal on the map no drive arrives or fails: all that is measured is reported, and ``success``, ``timeout``,
    ``spl`` and ``barn`` are left out. The last two need the map.

    References
    ----------
    .. [SPL] P. Anderson et al., On Evaluation of Embodied Navigation Agents, 2018, arXiv:1807.06757.
    .. [BARN] X. Xiao et al., Autonomous Ground Navigation in Highly Constrained Spaces: Lessons Learned From the
       Benchmark Autonomous Robot Navigation Challenge at ICRA 2022, IEEE RAM 29(4), 2022.
    """

    metrics: ClassVar[tuple[Metric, ...]] = (
        Metric(
            "success",
            better="higher",
            min_difference=0.05,
            if_failed=0.0,
            is_outcome=True,
            help="1 if the robot reached the goal without a contact, else 0.",
        ),
        Metric(
            "timeout",
            better="lower",
            min_difference=0.05,
            help="1 if it neither reached the goal nor touched anything, else 0.",
        ),
        Metric("collision", better="lower", min_difference=0.05, help="1 if it touched anything, else 0."),
        Metric(
            "min_clearance_m",
            unit="m",
            better="higher",
            min_difference=0.02,
            help="From the robot's rim to what was nearest, minimum over the drive; left out if nothing ever was.",
        ),
        Metric(
            "mean_clearance_m",
            unit="m",
            better="higher",
            min_difference=0.02,
            help="From the robot's rim to what was nearest, mean over the drive; left out if nothing ever was.",
        ),
        Metric(
            "path_length_m",
            unit="m",
            better="lower",
            min_difference=0.1,
            if_failed=UNDEFINED,
            help="Length of the path driven.",
        ),
        Metric(
            "duration_s",
            unit="s",
            better="lower",
            min_difference=0.5,
            if_failed=UNDEFINED,
            help="Time from first to last state.",
        ),
        Metric(
            "mean_jerk_mps3",
            unit="m/s³",
            better="lower",
            min_difference=0.02,
            if_failed=UNDEFINED,
            help="Mean length of the velocity's second derivative.",
        ),
        Metric(
            "spl",
            better="higher",
            min_difference=0.02,
            if_failed=0.0,
            help="Success weighted by path length: shortest path / max(path, shortest path), 0 if failed [SPL].",
        ),
        Metric(
            "barn",
            better="higher",
            min_difference=0.01,
            if_failed=0.0,
            help="Optimal time / clip(time, 2 x, 8 x optimal time), 0 if failed, 0.5 at best; the optimal time is that "
            "of the shortest path at `optimal_speed_mps` [BARN].",
        ),
    )

    optimal_speed_mps: float = param(
        0.5, gt=0.0, doc="speed of the drive that `barn` calls optimal; more makes the score stricter"
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Forget the last drive."""
        self._map: Map | None = None
        self._states = 0
        self._first_us = self._last_us = 0
        self._at_goal = self._contact = False
        self._min_clearance_m, self._sum_clearance_m = math.inf, 0.0
        self._path_m = 0.0
        self._place_m = (0.0, 0.0)
        self._jerk = MeanJerk()

    def step(self, state: State, map: Latest[Map], stamp: Stamp) -> None:  # noqa: A002  # the port's name
        """Count this state."""
        self._map = map.value or self._map
        place_m = (state.x_m, state.y_m)
        if not self._states:
            self._first_us, self._place_m = stamp, place_m
        self._path_m += math.dist(place_m, self._place_m)
        self._place_m, self._last_us = place_m, stamp
        self._states += 1
        self._at_goal |= state.at_goal
        self._contact |= state.contact
        self._min_clearance_m = min(self._min_clearance_m, state.clearance_m)
        self._sum_clearance_m += state.clearance_m
        velocity = (state.v_mps * math.cos(state.yaw_rad), state.v_mps * math.sin(state.yaw_rad))
        self._jerk.add(velocity, stamp * 1e-6)

    def summary(self) -> Mapping[str, float]:
        """Return the metrics of the drive so far, none before its first state."""
        if not self._states:
            return {}
        duration_s = (self._last_us - self._first_us) * 1e-6
        values = {
            "collision": float(self._contact),
            "min_clearance_m": self._min_clearance_m,
            "mean_clearance_m": self._sum_clearance_m / self._states,
            "path_length_m": self._path_m,
            "duration_s": duration_s,
        }
        if self._min_clearance_m >= NOTHING_NEAR_M:
            del values["min_clearance_m"], values["mean_clearance_m"]
        if self._jerk.mean_mps3 is not None:
            values["mean_jerk_mps3"] = self._jerk.mean_mps3
        has_goal = self._at_goal if self._map is None else len(self._map.goal_m) > 0
        if self._map is not None and not has_goal:
            return values
        success = self._at_goal and not self._contact
        values = {
            "success": float(success),
            "timeout": float(not success and not self._contact),
            **values,
        }
        if self._map is not None:
            values["spl"] = success * spl(self._map.shortest_m, self._path_m)
            values["barn"] = success * barn(self._map.shortest_m / self.optimal_speed_mps, duration_s)
        return values


class MeanJerk:
    """Mean length of the second derivative of a velocity (x, y), m/s^3, by differences."""

    def __init__(self) -> None:
        self._velocity: tuple[Pair, float] | None = None
        self._acceleration: tuple[Pair, float] | None = None
        self._sum, self._count = 0.0, 0

    @property
    def mean_mps3(self) -> float | None:
        """The mean; None for fewer than three velocities."""
        return self._sum / self._count if self._count else None

    def add(self, velocity_mps: Pair, time_s: float) -> None:
        """Count a velocity; times have to grow."""
        if self._velocity is not None:
            (x, y), then_s = self._velocity
            interval_s, middle_s = time_s - then_s, (time_s + then_s) / 2
            acceleration = (velocity_mps[0] - x) / interval_s, (velocity_mps[1] - y) / interval_s
            if self._acceleration is not None:
                earlier, earlier_s = self._acceleration
                self._sum += math.dist(acceleration, earlier) / (middle_s - earlier_s)
                self._count += 1
            self._acceleration = acceleration, middle_s
        self._velocity = velocity_mps, time_s


def spl(shortest_m: float, path_m: float) -> float:
    """Return shortest / max(path, shortest) of a successful drive; 1 where it began at its goal."""
    longer = max(path_m, shortest_m)
    return shortest_m / longer if longer > 0 else 1.0


def barn(optimal_s: float, duration_s: float) -> float:
    """Return optimal / clip(time, 2 x optimal, 8 x optimal) of a successful drive, 0.125 to 0.5."""
    if optimal_s == 0:
        return 0.5
    return optimal_s / min(max(duration_s, 2 * optimal_s), 8 * optimal_s)
