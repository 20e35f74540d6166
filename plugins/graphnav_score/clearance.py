"""How near the robot came to what is ahead of it and beside it, once it was on its way."""

from __future__ import annotations

import math
from collections.abc import Mapping

from graphnav import Map, Metric, State
from graphnav.arrays import Doubles
from graphnav_score.bodies import Bodies, nearest_m, nearest_to_m

METRICS = (
    Metric(
        "min_clearance_ahead_m",
        unit="m",
        better="higher",
        bounds=(0.0, None),
        min_difference=0.02,
        help="From the robot's rim to the nearest body within 45 degrees of straight ahead, minimum over the states "
        "after the first metre driven; moving bodies included; left out without the map, or if nothing ever was there.",
    ),
    Metric(
        "min_clearance_side_m",
        unit="m",
        better="higher",
        bounds=(0.0, None),
        min_difference=0.02,
        help="The same to the left and to the right, 45 to 135 degrees from straight ahead.",
    ),
)

_EIGHTH = math.pi / 4
_SECTORS = (("min_clearance_ahead_m", (-1,)), ("min_clearance_side_m", (1, -3)))
"""Where sectors of a quarter turn begin, in eighths of a turn from straight ahead."""


class SectorClearance:
    """The minimum clearance ahead and to the sides of a drive through one map."""

    def __init__(self, world: Map) -> None:
        self._bodies = Bodies(world.surroundings())
        self._radius_m, self._outline_m = world.robot_radius_m, world.robot_outline_m
        self._min_m = {metric.name: math.inf for metric in METRICS}

    def add(self, state: State, driven_m: float) -> None:
        """Count this state, if the robot has driven a metre."""
        if driven_m < State.UNDER_WAY_M or not len(self._bodies.body):
            return
        # Nothing in a sector is nearer than what is nearest in all directions.
        sectors = [(name, eighths) for name, eighths in _SECTORS if state.clearance_m < self._min_m[name]]
        if not sectors:
            return
        ends_m = self._bodies.edges_m(state)
        for name, eighths in sectors:
            distances_m = (self._clearance_m(ends_m, begin * _EIGHTH, (begin + 2) * _EIGHTH) for begin in eighths)
            self._min_m[name] = min(self._min_m[name], max(min(distances_m), 0.0))

    def _clearance_m(self, ends_m: Doubles, begin_rad: float, end_rad: float) -> float:
        """Return how far the nearest edge in a sector is from the rim: a circle, or the outline of another robot."""
        if self._outline_m is None:
            return float(nearest_m(ends_m, begin_rad, end_rad).min()) - self._radius_m
        return float(nearest_to_m(self._outline_m, ends_m, begin_rad, end_rad).min())

    def metrics(self) -> Mapping[str, float]:
        """Return the metrics that are defined."""
        return {name: value for name, value in self._min_m.items() if math.isfinite(value)}
