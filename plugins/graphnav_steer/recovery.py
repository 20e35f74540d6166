"""Recovery of a robot that turns on one place and does not get on."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar, NamedTuple

import numpy as np

from graphnav import LocalMap, Metric, RecoveryState, Stage, Steering, param
from graphnav_steer.headings import headed

_PLACE_M = 0.5
"""A robot that leaves a circle of this radius gets on."""
_MIN_TURN_RAD = 0.1
"""Turns that are smaller do not count: visual odometry of a robot that stands is not exactly 0."""
_SAME_PLACE_M = 2.0
"""A recovery that begins nearer to the last one continues it: it doubts more."""
_MIN_BACK_M = 0.15
"""How far the floor behind has to be free at least: less shows what is ahead from hardly another place."""
_MAX_DOUBT = 1e6
_REVOLUTION_RAD = 2 * math.pi


class RecoveryOutputs(NamedTuple):
    """Outputs of `Recovery`."""

    steering: Steering
    state: RecoveryState


class Recovery(Stage):
    """Passes the steering on while the robot gets on; if it turns on one place instead, it recovers in three steps.

    A robot to which no way is left turns on the spot, and one that cannot decide turns to and fro. It does not get on
    when it has turned by ``turns`` full turns, to either side, within a circle of 0.5 m. Then three steps begin, one
    after the other, each when it has turned there by ``step_turns`` more:

    1. ``look_again``: the map is to forget obstacles that fewer frames than ``doubt`` have shown. A false obstacle that
       shut the robot in is mostly one of these, and what is really there is seen again as soon as the robot drives.
    2. ``other_way``: the planner is to take ways that it has thought too little of; `steer.frontier` takes smaller
       frontiers.
    3. ``back_out``: the robot drives straight back by ``back_m``, over floor that is known to be free: once there is as
       much behind it, or, after half of this step, as far as there is. ``control.nonholonomic`` needs ``reversing`` for
       that. What is ahead is seen again, from other places.

    If that does not help, it begins again, and the map is to forget what twice as many frames have shown. A robot that
    stands still is not noticed: it may be held.
    """

    metrics: ClassVar[tuple[Metric, ...]] = (
        Metric("recoveries", better="lower", bounds=(0.0, None), help="How often a recovery began."),
    )

    turns: float = param(
        2.0, ge=0.0, le=1000.0, doc="dimensionless: full turns on one place after which a recovery begins; 0: never"
    )
    step_turns: float = param(
        1.0, gt=0.0, le=1000.0, doc="dimensionless: full turns on one place after which the next step begins"
    )
    doubt: float = param(
        8.0,
        ge=0.0,
        le=_MAX_DOUBT,
        doc="dimensionless: full frames; what fewer have shown is forgotten, twice as many if that does not help",
    )
    back_m: float = param(0.6, ge=0.0, le=10.0, doc="how far the robot drives back; 0: it does not")
    robot_radius_m: float = param(0.2, gt=0.0, le=10.0, doc="radius of the robot's body")

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Begin on a new place."""
        self._place: _Place | None = None
        self._began_at: _Place | None = None
        self._doing = ""
        self._recoveries = 0
        self._doubt = self.doubt
        self._back_from: tuple[float, float] | None = None

    def step(self, steering: Steering, map: LocalMap) -> RecoveryOutputs:  # noqa: A002  # the port's name
        """Return the steering, or straight back, and what is done."""
        place = self._place = _Place.at(map) if self._place is None else self._place.after(map)
        if self._back_from is not None:
            self._end_backing(map, self._back_from)
        elif place.is_new:
            self._doing = ""
        elif self.turns:
            self._next(place, map)
        if self._back_from is not None:
            steering = headed(math.pi)
        state = RecoveryState(
            doing=self._doing,
            recoveries=self._recoveries,
            turned_rad=self._place.turned_rad,
            doubt=self._doubt,
        )
        return RecoveryOutputs(steering, state)

    def summary(self) -> Mapping[str, float]:
        """Return how often a recovery began."""
        return {"recoveries": float(self._recoveries)}

    def _next(self, place: _Place, map: LocalMap) -> None:  # noqa: A002
        """Begin the next step of the recovery if the robot has turned long enough."""
        turned = place.turned_rad / _REVOLUTION_RAD
        if not self._doing and turned >= self.turns:
            self._begin(place)
        elif self._doing == "look_again" and turned >= self.turns + self.step_turns:
            self._doing = "other_way"
        elif self._doing == "other_way" and turned >= self.turns + 2 * self.step_turns:
            self._doing = "back_out"
        if self._doing == "back_out":
            is_late = turned >= self.turns + 2.5 * self.step_turns
            if turned >= self.turns + 3 * self.step_turns:
                self._begin_again(map)
            elif self._is_free_behind(map, min(self.back_m, _MIN_BACK_M) if is_late else self.back_m):
                self._back_from = map.x_m, map.y_m

    def _begin(self, place: _Place) -> None:
        is_same = self._began_at is not None and self._began_at.distance_m(place) < _SAME_PLACE_M
        self._doubt = min(2 * self._doubt, _MAX_DOUBT) if is_same else self.doubt
        self._began_at = place
        self._doing = "look_again"
        self._recoveries += 1

    def _begin_again(self, map: LocalMap) -> None:  # noqa: A002
        self._doing = ""
        self._back_from = None
        self._place = _Place.at(map)

    def _end_backing(self, map: LocalMap, begin: tuple[float, float]) -> None:  # noqa: A002
        is_blocked = not self._is_free_behind(map, 2 * map.cell_m)
        if is_blocked or math.dist(begin, (map.x_m, map.y_m)) >= self.back_m:
            self._begin_again(map)

    def _is_free_behind(self, map: LocalMap, way_m: float) -> bool:  # noqa: A002
        """Whether all floor below the robot is known to be free if it drives straight back so far."""
        steps_m = np.arange(0.0, way_m + map.cell_m, map.cell_m)
        aside_m = np.zeros_like(steps_m)
        clear_m = np.minimum(map.obstacle_m_at(-steps_m, aside_m), map.unknown_m_at(-steps_m, aside_m))
        return bool(self.back_m and clear_m.min() >= self.robot_radius_m)


class _Place(NamedTuple):
    """Where the robot got on last, the heading up to which turns count, and how far it has turned there."""

    x_m: float
    y_m: float
    yaw_rad: float
    turned_rad: float = 0.0

    @classmethod
    def at(cls, map: LocalMap) -> _Place:  # noqa: A002
        return cls(map.x_m, map.y_m, map.yaw_rad)

    @property
    def is_new(self) -> bool:
        return not self.turned_rad

    def after(self, map: LocalMap) -> _Place:  # noqa: A002
        """Return the place with the turn to where the robot is on the map now, or a new one."""
        here = _Place.at(map)
        if self.distance_m(here) > _PLACE_M:
            return here
        turn_rad = abs(math.remainder(here.yaw_rad - self.yaw_rad, _REVOLUTION_RAD))
        if turn_rad < _MIN_TURN_RAD:
            return self
        return self._replace(yaw_rad=here.yaw_rad, turned_rad=self.turned_rad + turn_rad)

    def distance_m(self, other: _Place) -> float:
        return math.dist(self[:2], other[:2])
