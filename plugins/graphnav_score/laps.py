"""How a drive around went: laps, and whether it lasted."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from graphnav import Latest, Map, Metric, Stamp, State, param
from graphnav_score.navigation import Navigation

_WITH_GOAL = ("success", "timeout", "spl", "sct", "oracle_spl")
"""Metrics of a drive to a goal; ``success`` is another one here."""


class Laps(Navigation):
    """How a drive around a closed corridor, which has no goal, went: `score.navigation`, and laps.

    A lap is a turn of the direction from the middle of the map, of the bounds of all that stands on it, to the robot:
    what is driven back does not count. The drive is a success if it lasts ``duration_s`` without a contact and goes
    round ``min_laps`` times, to either side.
    """

    metrics: ClassVar[tuple[Metric, ...]] = (
        Metric(
            "success",
            better="higher",
            min_difference=0.05,
            if_failed=0.0,
            is_outcome=True,
            help="1 if the robot went round for `duration_s` without a contact, `min_laps` times at least, else 0.",
        ),
        Metric(
            "laps",
            better="higher",
            min_difference=0.1,
            help="How often the robot went round, to either side; parts of a lap count.",
        ),
        *(metric for metric in Navigation.metrics if metric.name not in _WITH_GOAL),
    )

    duration_s: float = param(600.0, gt=0.0, doc="how long a success lasts; the run must last as long")
    min_laps: float = param(1.0, ge=0.0, doc="dimensionless: how many laps a success has at least")

    def reset(self, seed: int) -> None:
        """Forget the last drive."""
        super().reset(seed)
        self._middle_m: tuple[float, float] | None = None
        self._bearing_rad: float | None = None
        self._turn_rad = 0.0

    def step(self, state: State, map: Latest[Map], stamp: Stamp) -> None:  # noqa: A002  # the port's name
        """Count this state."""
        super().step(state, map, stamp)
        if self._middle_m is None and map.value is not None:
            self._middle_m = _middle_m(map.value)
        if self._middle_m is None:
            return
        x, y = self._middle_m
        bearing_rad = math.atan2(state.y_m - y, state.x_m - x)
        if self._bearing_rad is not None:
            self._turn_rad += math.remainder(bearing_rad - self._bearing_rad, 2 * math.pi)
        self._bearing_rad = bearing_rad

    def summary(self) -> Mapping[str, float]:
        """Return the metrics of the drive so far, none before its first state."""
        values = {name: value for name, value in super().summary().items() if name not in _WITH_GOAL}
        if not values:
            return {}
        laps = abs(self._turn_rad) / (2 * math.pi)
        lasted = values["duration_s"] >= self.duration_s - 1e-6 and not values["collision"]
        return {"success": float(lasted and laps >= self.min_laps), "laps": laps, **values}


def _middle_m(world: Map) -> tuple[float, float] | None:
    """Return the middle of the bounds of all that stands, (x, y) in W; None if nothing does."""
    points_m = world.vertices_m[world.kind[world.body] != Map.MOVING]
    if not len(points_m):
        return None
    x, y = (np.min(points_m, axis=0) + np.max(points_m, axis=0)) / 2
    return float(x), float(y)
