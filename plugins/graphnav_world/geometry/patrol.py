"""The path of a moving obstacle: along a polyline and back, or around it, at constant speed."""

from __future__ import annotations

from dataclasses import dataclass

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

    def at(self, time_s: float) -> Doubles:
        """Return the position (x, y) in W."""
        stops = np.concatenate([self.through_m, self.through_m[:1] if self.around else self.through_m[-2::-1]])
        legs = np.linalg.norm(np.diff(stops, axis=0), axis=1)
        run = np.concatenate([[0.0], np.cumsum(legs)])
        here = (self.ahead_m + self.speed_mps * time_s) % run[-1] if run[-1] else 0.0
        return np.array([np.interp(here, run, stops[:, 0]), np.interp(here, run, stops[:, 1])])
