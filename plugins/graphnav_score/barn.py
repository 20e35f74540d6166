"""The metric of the BARN challenge, of a drive through one of its worlds."""

from __future__ import annotations

import math
import zlib
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import ClassVar

import numpy as np

from graphnav import UNDEFINED, Latest, Map, Metric, Stamp, State
from graphnav_score.navigation import Navigation

WORLDS = Path(__file__).with_name("barn_worlds.npz")
CELL_M = 0.15
FIRST_M = (-4.425, 0.075)
"""Of the grid of cylinders, as BARN has it."""
MOVED_M = 0.1
TIMEOUT_S = 100.0
SPEED_MPS = 2.0
"""Of the optimal drive along the reference path."""


class Barn(Navigation):
    """How a drive through a world of the BARN challenge went: `score.navigation`, and the challenge's metric.

    The time counts from when the robot is 0.1 m from where it started; what comes 100 s later does not count any more.
    With OT, the length of the world's reference path / 2 m/s, and AT, the time taken, the metric is
    success x OT / clip(AT, 2 OT, 8 OT): at most 0.5.

    The world, and so the length of its reference path, is recognised by the cylinders on the map. That length is to the
    middle of the goal, a metre farther than a drive has to come; ``spl`` and ``sct`` are by the map's shortest path.

    References
    ----------
    .. [BARN] D. Perille, A. Truong, X. Xiao, P. Stone, Benchmarking Metric Ground Navigation, SSRR 2020; its challenge,
       https://github.com/Daffan/the-barn-challenge.
    """

    metrics: ClassVar[tuple[Metric, ...]] = (
        *(metric for metric in Navigation.metrics if metric.name == "success"),
        Metric(
            "barn_metric",
            better="higher",
            min_difference=0.01,
            if_failed=0.0,
            is_key=True,
            bounds=(0.0, 0.5),
            help="Success x OT / clip(AT, 2 OT, 8 OT), where AT is the time from 0.1 m of motion to the goal and OT "
            "that of the world's reference path at 2 m/s [BARN]; 0 if failed.",
        ),
        Metric(
            "arrival_s",
            unit="s",
            better="lower",
            bounds=(0.0, TIMEOUT_S),
            min_difference=0.5,
            if_failed=UNDEFINED,
            help="Time from 0.1 m of motion to the goal.",
        ),
        *(metric for metric in Navigation.metrics if metric.name != "success"),
    )

    def reset(self, seed: int) -> None:
        """Forget the last drive."""
        super().reset(seed)
        self._reference_m: float | None = None
        self._start_m: tuple[float, float] | None = None
        self._moved_us: int | None = None

    def step(self, state: State, map: Latest[Map], stamp: Stamp) -> None:  # noqa: A002  # the port's name
        """Count this state, until the time has ended.

        Raises
        ------
        ValueError
            The map is not a world of BARN.
        """
        if self._reference_m is None and map.value is not None:
            self._reference_m = reference_m(map.value)
        if self._start_m is None:
            self._start_m = state.x_m, state.y_m
        if self._moved_us is None and math.dist(self._start_m, (state.x_m, state.y_m)) >= MOVED_M:
            self._moved_us = stamp
        if self._moved_us is None or stamp - self._moved_us < TIMEOUT_S * 1e6:
            super().step(state, map, stamp)

    def summary(self) -> Mapping[str, float]:
        """Return the metrics of the drive so far, none before its first state."""
        values = super().summary()
        if "success" not in values or self._reference_m is None:
            return values
        if not values["success"]:
            return {**values, "barn_metric": 0.0}
        arrival_s = 0.0 if self._moved_us is None else (self._last_us - self._moved_us) * 1e-6
        return {**values, "barn_metric": metric_of(self._reference_m, arrival_s), "arrival_s": arrival_s}


def metric_of(reference_m: float, arrival_s: float) -> float:
    """Return the challenge's metric of a drive that arrived, from the reference path's length and the time taken."""
    optimal_s = reference_m / SPEED_MPS
    return optimal_s / min(max(arrival_s, 2 * optimal_s), 8 * optimal_s)


def reference_m(world: Map) -> float:
    """Return the length of the reference path of the world that a map shows.

    Raises
    ------
    ValueError
        It has other obstacles than a world of BARN.
    """
    middles = [world.vertices_m[world.body == body].mean(axis=0) for body in np.flatnonzero(world.kind == Map.OBSTACLE)]
    cells = np.round((np.array(middles).reshape(-1, 2) - FIRST_M) / CELL_M).astype(np.int64)
    found = _reference_m().get(cells_crc32(cells))
    if found is None:
        raise ValueError("the map is not a world of BARN: use a map with 'barn' and no other obstacles")
    return found


def cells_crc32(cells: np.ndarray[tuple[int, ...], np.dtype[np.int64]]) -> int:
    """Return the checksum of columns and rows of cylinders, (n, 2), in any order."""
    return zlib.crc32(np.unique(cells, axis=0).astype("<i4").tobytes())


@lru_cache(maxsize=1)
def _reference_m() -> Mapping[int, float]:
    """Return the lengths of the reference paths, by the checksum of a world's cylinders."""
    with np.load(WORLDS) as stored:
        return dict(zip(stored["cells_crc32"].tolist(), stored["path_length_m"].tolist(), strict=True))
