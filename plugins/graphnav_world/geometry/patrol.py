"""The path of a moving obstacle: along a polyline and back, or around it, at constant speed."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from graphnav.arrays import Doubles


@dataclass(frozen=True)
class Patrol:
    """The position of an obstacle at any time; it does not turn.

    ``through_m``: float64 (n, 2), in W. ``around``: from the last point straight on to the first; else it
    returns along the same path. ``ahead_m``: its distance along the path at time zero.
    """

    through_m: Doubles
    speed_mps: float
    around: bool = False
    ahead_m: float = 0.0

    def at(self, time_s: float) -> tuple[float, float]:
        """Return the position (x, y) in W."""
        run, x_m, y_m = self._stops
        here = (self.ahead_m + self.speed_mps * time_s) % run[-1] if run[-1] else 0.0
        leg = bisect_right(run, here, 0, len(run) - 1) - 1
        length_m, ahead_m = run[leg + 1] - run[leg], here - run[leg]
        if not length_m:
            return x_m[leg], y_m[leg]
        x_slope, y_slope = (x_m[leg + 1] - x_m[leg]) / length_m, (y_m[leg + 1] - y_m[leg]) / length_m
        return x_slope * ahead_m + x_m[leg], y_slope * ahead_m + y_m[leg]

    @cached_property
    def _stops(self) -> tuple[list[float], list[float], list[float]]:
        """Distance along the path and position of every point at which it turns, back to the first."""
        stops = np.concatenate([self.through_m, self.through_m[:1] if self.around else self.through_m[-2::-1]])
        legs = np.linalg.norm(np.diff(stops, axis=0), axis=1)
        return [0.0, *np.cumsum(legs).tolist()], stops[:, 0].tolist(), stops[:, 1].tolist()
