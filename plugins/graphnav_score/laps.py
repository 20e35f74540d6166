"""How a drive around went: laps, and whether it lasted."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from graphnav import Latest, Map, Metric, Stamp, State, param
from graphnav.arrays import Doubles
from graphnav_score.navigation import Navigation

_WITH_GOAL = ("success", "timeout", "spl", "sct", "oracle_spl")
"""Metrics of a drive to a goal; ``success`` is another one here."""
_BEARINGS = 360
"""Rays from the middle of a corridor that find its centreline: one a degree."""


class Laps(Navigation):
    """How a drive around a closed corridor, which has no goal, went: `score.navigation`, and laps.

    A lap is a turn of the direction from the middle of the map, of the bounds of all that stands on it, to the robot:
    what is driven back does not count. The drive is a success if it lasts ``duration_s`` without a contact and goes
    round ``min_laps`` times, to either side.

    Progress is measured along the corridor's centreline, from the bearing of the first place to that of the last: the
    centreline is midway between the outlines that a ray from the middle passes, a ray a degree. Where a ray passes less
    than two outlines, the map is not a corridor around its middle, and progress is left out.
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
            bounds=(0.0, None),
            min_difference=0.1,
            help="How often the robot went round, to either side; parts of a lap count.",
        ),
        Metric(
            "progress_m",
            unit="m",
            better="higher",
            bounds=(0.0, None),
            min_difference=0.5,
            help="How far it came along the corridor's centreline, to either side; what is driven back does not count.",
        ),
        Metric(
            "progress_ratio",
            unit="ratio",
            better="higher",
            bounds=(0.0, None),
            min_difference=0.02,
            help="`progress_m` / (`max_speed_mps` x `duration_s` of the parameters): the share of what the highest "
            "speed allows; above 1 where the robot cuts the bends, and less after a contact, which ends the drive.",
        ),
        *(metric for metric in Navigation.metrics if metric.name not in _WITH_GOAL),
    )

    duration_s: float = param(600.0, gt=0.0, le=1e6, doc="how long a success lasts; the run must last as long")
    min_laps: float = param(1.0, ge=0.0, le=1e6, doc="dimensionless: how many laps a success has at least")
    max_speed_mps: float = param(
        0.3, gt=0.0, le=1000.0, doc="highest speed that the graph commands, for `progress_ratio`"
    )

    def reset(self, seed: int) -> None:
        """Forget the last drive."""
        super().reset(seed)
        self._middle_m: tuple[float, float] | None = None
        self._centreline: Centreline | None = None
        self._first_rad: float | None = None
        self._bearing_rad: float | None = None
        self._turn_rad = 0.0

    def step(self, state: State, map: Latest[Map], stamp: Stamp) -> None:  # noqa: A002  # the port's name
        """Count this state."""
        super().step(state, map, stamp)
        if self._middle_m is None and map.value is not None:
            world = map.value.surroundings()
            self._middle_m = _middle_m(world)
            self._centreline = Centreline.of(world, self._middle_m) if self._middle_m else None
        if self._middle_m is None:
            return
        x, y = self._middle_m
        bearing_rad = math.atan2(state.y_m - y, state.x_m - x)
        if self._bearing_rad is None:
            self._first_rad = bearing_rad
        else:
            self._turn_rad += math.remainder(bearing_rad - self._bearing_rad, 2 * math.pi)
        self._bearing_rad = bearing_rad

    def summary(self) -> Mapping[str, float]:
        """Return the metrics of the drive so far, none before its first state."""
        values = {name: value for name, value in super().summary().items() if name not in _WITH_GOAL}
        if not values:
            return {}
        laps = abs(self._turn_rad) / (2 * math.pi)
        lasted = values["duration_s"] >= self.duration_s - 1e-6 and not values["collision"]
        return {"success": float(lasted and laps >= self.min_laps), "laps": laps, **self._progress(), **values}

    def _progress(self) -> Mapping[str, float]:
        if self._centreline is None or self._first_rad is None:
            return {}
        last_rad = self._first_rad + self._turn_rad
        progress_m = abs(self._centreline.along_m(last_rad) - self._centreline.along_m(self._first_rad))
        return {"progress_m": progress_m, "progress_ratio": progress_m / (self.max_speed_mps * self.duration_s)}


def _middle_m(world: Map) -> tuple[float, float] | None:
    """Return the middle of the bounds of all that stands, (x, y) in W; None if nothing does."""
    points_m = world.vertices_m[world.kind[world.body] != Map.MOVING]
    if not len(points_m):
        return None
    x, y = (np.min(points_m, axis=0) + np.max(points_m, axis=0)) / 2
    return float(x), float(y)


class Centreline:
    """Lengths along the middle of a closed corridor around ``middle_m``, (x, y) in W.

    A ray a degree leaves the middle. Where it passes the outlines of what stands, its longest piece between two of them
    is the corridor, and the middle of that piece is on the centreline.
    """

    def __init__(self, points_m: Doubles) -> None:
        ways = np.hypot(*(np.roll(points_m, -1, axis=0) - points_m).T)
        self._length_m = np.concatenate([[0.0], np.cumsum(ways)])

    @classmethod
    def of(cls, world: Map, middle_m: tuple[float, float]) -> Centreline | None:
        """Return the centreline of a map's corridor; None if some ray does not pass between two outlines."""
        starts, ends = _edges(world, middle_m)
        points: list[Doubles] = []
        for bearing_rad in _bearings():
            ray = np.array([math.cos(bearing_rad), math.sin(bearing_rad)])
            away_m = _crossings_m(ray, starts, ends)
            if len(away_m) < 2:
                return None
            widest = int(np.argmax(np.diff(away_m)))
            points.append(ray * (away_m[widest] + away_m[widest + 1]) / 2)
        return cls(np.array(points))

    def along_m(self, bearing_rad: float) -> float:
        """Return the length from bearing 0 to this one, which may be of several turns, to either side."""
        turns, share = divmod(bearing_rad / (2 * math.pi), 1.0)
        within = np.interp(share * _BEARINGS, np.arange(_BEARINGS + 1), self._length_m)
        return float(turns * self._length_m[-1] + within)


def _bearings() -> Doubles:
    return np.asarray(np.arange(_BEARINGS) * (2 * math.pi / _BEARINGS), np.float64)


def _edges(world: Map, middle_m: tuple[float, float]) -> tuple[Doubles, Doubles]:
    """Return where the edges of all that stands begin and end, from the middle, each (n, 2)."""
    outlines = [world.vertices_m[world.body == body] for body in np.flatnonzero(world.kind != Map.MOVING)]
    starts = [outline - np.array(middle_m) for outline in outlines]
    ends = [np.roll(start, -1, axis=0) for start in starts]
    return np.concatenate([np.zeros((0, 2)), *starts]), np.concatenate([np.zeros((0, 2)), *ends])


def _crossings_m(ray: Doubles, starts: Doubles, ends: Doubles) -> Doubles:
    """Return how far along a ray of length 1 it crosses edges, sorted."""
    along, across = starts @ ray, starts @ np.array([-ray[1], ray[0]])
    to_along, to_across = ends @ ray, ends @ np.array([-ray[1], ray[0]])
    crosses = (across > 0) != (to_across > 0)
    share = across[crosses] / (across[crosses] - to_across[crosses])
    away_m: Doubles = along[crosses] + share * (to_along[crosses] - along[crosses])
    return np.sort(away_m[away_m > 0])
