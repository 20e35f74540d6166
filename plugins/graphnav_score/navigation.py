"""How a drive went: success, safety, length, time, smoothness."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

from graphnav import UNDEFINED, Latest, Map, Metric, Role, Stage, Stamp, State, param
from graphnav_score import clearance
from graphnav_score.first_contact import CONTACT_METRICS, FirstContact

NOTHING_NEAR_M = 1000.0
"""The clearance that `State` gives where there is nothing."""

Pair = tuple[float, float]


class Navigation(Stage):
    """How a drive went.

    Without a goal on the map no drive arrives or fails: all that is measured is reported, and ``success``, ``timeout``,
    ``spl`` and ``sct`` are left out. The last two and the clearances of sectors need the map.

    Minimum clearances count once the first metre is driven: what is nearest at the start says nothing of the drive. A
    contact before counts in ``min_clearance_m``; a drive that ends before without one has no minimum clearance.

    References
    ----------
    .. [SPL] P. Anderson et al., On Evaluation of Embodied Navigation Agents, 2018, arXiv:1807.06757.
    .. [SCT] N. Yokoyama, S. Ha, D. Batra, Success Weighted by Completion Time: A Dynamics-Aware Evaluation Criteria
       for Embodied Navigation, IROS 2021, arXiv:2103.08022.
    """

    role: ClassVar[Role] = "score"
    metrics: ClassVar[tuple[Metric, ...]] = (
        Metric(
            "success",
            better="higher",
            min_difference=0.05,
            if_failed=0.0,
            is_outcome=True,
            is_key=True,
            help="1 if the robot reached the goal without a contact, else 0.",
        ),
        Metric(
            "timeout",
            better="lower",
            min_difference=0.05,
            help="1 if it neither reached the goal nor touched anything, else 0.",
            bounds=(0.0, 1.0),
        ),
        Metric(
            "collision",
            better="lower",
            min_difference=0.05,
            help="1 if it touched anything, else 0.",
            bounds=(0.0, 1.0),
        ),
        *CONTACT_METRICS,
        Metric(
            "min_clearance_m",
            unit="m",
            better="higher",
            bounds=(0.0, None),
            min_difference=0.02,
            help="From the robot's rim to what was nearest in any direction, minimum over the states after the first "
            "metre driven and those in contact; left out without such a state, or if nothing ever was near.",
        ),
        *clearance.METRICS,
        Metric(
            "mean_clearance_m",
            unit="m",
            better="higher",
            bounds=(0.0, None),
            min_difference=0.02,
            help="From the robot's rim to what was nearest in any direction, mean over the drive from its start on; "
            "left out if nothing ever was near.",
        ),
        Metric(
            "path_length_m",
            unit="m",
            better="lower",
            bounds=(0.0, None),
            min_difference=0.1,
            if_failed=UNDEFINED,
            help="Length of the path driven.",
        ),
        Metric(
            "duration_s",
            unit="s",
            better="lower",
            bounds=(0.0, None),
            min_difference=0.5,
            if_failed=UNDEFINED,
            help="Time from first to last state.",
        ),
        Metric(
            "mean_jerk_mps3",
            unit="m/s³",
            better="lower",
            bounds=(0.0, None),
            min_difference=0.02,
            if_failed=UNDEFINED,
            help="Mean length of the velocity's second derivative.",
        ),
        Metric(
            "spl",
            better="higher",
            min_difference=0.02,
            if_failed=0.0,
            is_key=True,
            help="Success weighted by path length: shortest path / max(path, shortest path), 0 if failed [SPL].",
            bounds=(0.0, 1.0),
        ),
        Metric(
            "oracle_spl",
            better="higher",
            min_difference=0.02,
            if_failed=0.0,
            relative_to="path_length_m",
            bounds=(0.0, 1.0),
            help="The path of the study's `reference` in the same world / max(path, reference's path), 0 if failed; "
            "left out where the reference has no run or did not arrive.",
        ),
        Metric(
            "sct",
            better="higher",
            min_difference=0.02,
            if_failed=0.0,
            help="Success weighted by completion time: optimal time / max(time, optimal time), 0 if failed; the "
            "optimal time is that of the shortest path at `optimal_speed_mps` [SCT].",
            bounds=(0.0, 1.0),
        ),
    )

    optimal_speed_mps: float | None = param(
        None,
        gt=0.0,
        le=1000.0,
        doc="speed of the drive that `sct` calls optimal; more makes the score stricter; null: the highest speed of "
        "the robot in this drive",
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Forget the last drive."""
        self._map: Map | None = None
        self._sectors: clearance.SectorClearance | None = None
        self._max_speed_mps = 0.0
        self._states = 0
        self._first_us = self._last_us = 0
        self._at_goal = self._contact = False
        self._min_clearance_m, self._sum_clearance_m, self._is_near = math.inf, 0.0, False
        self._path_m = 0.0
        self._place_m = (0.0, 0.0)
        self._jerk = MeanJerk()
        self._first_contact = FirstContact()

    def step(self, state: State, map: Latest[Map], stamp: Stamp) -> None:  # noqa: A002  # the port's name
        """Count this state."""
        if map.value is not None and map.value is not self._map:
            self._map, self._sectors = map.value, clearance.SectorClearance(map.value)
        place_m = (state.x_m, state.y_m)
        if not self._states:
            self._first_us, self._place_m = stamp, place_m
        self._path_m += math.dist(place_m, self._place_m)
        self._place_m, self._last_us = place_m, stamp
        self._max_speed_mps = max(self._max_speed_mps, abs(state.v_mps))
        if self._sectors is not None:
            self._sectors.add(state, self._path_m)
        self._states += 1
        self._at_goal |= state.at_goal
        self._contact |= state.contact
        if state.contact or self._path_m >= State.UNDER_WAY_M:
            self._min_clearance_m = min(self._min_clearance_m, state.clearance_m)
        self._is_near |= state.clearance_m < NOTHING_NEAR_M
        self._sum_clearance_m += state.clearance_m
        velocity = (state.v_mps * math.cos(state.yaw_rad), state.v_mps * math.sin(state.yaw_rad))
        self._jerk.add(velocity, stamp * 1e-6)
        self._first_contact.add(state, self._map, stamp * 1e-6)

    def summary(self) -> Mapping[str, float]:
        """Return the metrics of the drive so far, none before its first state."""
        if not self._states:
            return {}
        duration_s = (self._last_us - self._first_us) * 1e-6
        values = {
            "collision": float(self._contact),
            **self._first_contact.metrics(self._map),
            "min_clearance_m": self._min_clearance_m,
            "path_length_m": self._path_m,
            "mean_clearance_m": self._sum_clearance_m / self._states,
            "duration_s": duration_s,
        }
        if self._min_clearance_m >= NOTHING_NEAR_M:
            del values["min_clearance_m"]
        if not self._is_near:
            del values["mean_clearance_m"]
        if self._sectors is not None:
            values |= self._sectors.metrics()
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
            # Times at one speed compare as lengths do.
            optimal_m = (self.optimal_speed_mps or self._max_speed_mps) * duration_s
            values["sct"] = success * spl(self._map.shortest_m, optimal_m)
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
