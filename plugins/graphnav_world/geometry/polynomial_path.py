"""The path of an obstacle along the graph of a polynomial, to and fro, at a speed that rises and falls."""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import chebyshev

from graphnav.arrays import Doubles

KNOTS = 257
"""At which the distance along the path is tabulated."""
TURN_M = 0.5
"""Before the end of its way an obstacle slows down over this distance and back, as if the turn were sharp: at 1 m/s by
2 m/s²."""


@dataclass(frozen=True)
class PolynomialPath:
    """A position along a polynomial at any time; it does not turn, and its velocity is continuous.

    ``series_m``: float64 (order + 1, 2), Chebyshev series of x and y, in W, over -1 to 1; one of the two coordinates
    is linear, so that the path nowhere stands still or turns back. It is followed to its end and back: near both ends
    the obstacle slows down at a constant rate, and elsewhere its speed is ``mean_mps`` + ``swing_mps`` cos(2π t /
    ``swing_s`` + ``phase_rad``), which has a standard deviation of ``swing_mps`` / √2. ``ahead_m``: its distance along
    the way at time zero.
    """

    series_m: Doubles
    mean_mps: float
    swing_mps: float = 0.0
    swing_s: float = 1.0
    phase_rad: float = 0.0
    ahead_m: float = 0.0

    @property
    def speed_mps(self) -> float:
        """The maximum of its speed."""
        return self.mean_mps + abs(self.swing_mps)

    @property
    def order(self) -> int:
        """The order of the polynomial."""
        return len(self.series_m) - 1

    def at(self, time_s: float) -> tuple[float, float]:
        """Return the position (x, y) in W."""
        u = self._at_distance(self._folded(self._driven_m(time_s)))
        return _value(self._series[0], u), _value(self._series[1], u)

    @cached_property
    def through_m(self) -> Doubles:
        """Points along the path, (n, 2), in W."""
        return np.array(chebyshev.chebval(np.linspace(-1.0, 1.0, KNOTS), self.series_m).T)

    @cached_property
    def length_m(self) -> float:
        """The length of the path, from end to end."""
        return self._table[0][-1]

    @property
    def sharpest_m(self) -> float:
        """The radius of its sharpest bend, infinite for a line."""
        at = np.linspace(-1.0, 1.0, KNOTS)
        dx, dy = chebyshev.chebval(at, chebyshev.chebder(self.series_m))
        ddx, ddy = chebyshev.chebval(at, chebyshev.chebder(self.series_m, 2))
        sharpest = float((np.abs(dx * ddy - dy * ddx) / np.hypot(dx, dy) ** 3).max())
        return 1.0 / sharpest if sharpest else math.inf

    def _driven_m(self, time_s: float) -> float:
        rate = 2 * math.pi / self.swing_s
        swung_m = self.swing_mps / rate * (math.sin(rate * time_s + self.phase_rad) - math.sin(self.phase_rad))
        return self.ahead_m + self.mean_mps * time_s + swung_m

    def _folded(self, driven_m: float) -> float:
        """Return the distance from the path's beginning after a way to and fro, whose turns are parabolas of time."""
        turn_m = min(TURN_M, self.length_m)
        leg_m = self.length_m + turn_m  # from turn to turn, if they were sharp
        sharp_m = leg_m - abs(leg_m - (driven_m + turn_m / 2) % (2 * leg_m))
        near, far = max(turn_m - sharp_m, 0.0), max(turn_m - (leg_m - sharp_m), 0.0)
        return min(max(sharp_m - turn_m / 2 + (near**2 - far**2) / (2 * turn_m), 0.0), self.length_m)

    def _at_distance(self, distance_m: float) -> float:
        """Return where the series has this distance along the path: cubic between knots, whose slopes are exact."""
        at_m, slopes = self._table
        k = min(bisect_right(at_m, distance_m), KNOTS - 1) - 1
        step_m, step = at_m[k + 1] - at_m[k], 2.0 / (KNOTS - 1)
        share = (distance_m - at_m[k]) / step_m
        rest = 1.0 - share
        bent = share * rest * ((slopes[k] * step_m - step) * rest + (step - slopes[k + 1] * step_m) * share)
        return -1.0 + (k + share) * step + bent

    @cached_property
    def _table(self) -> tuple[list[float], list[float]]:
        """Distance along the path at every knot, and there the slope of the series' argument over the distance."""
        derivative = chebyshev.chebder(self.series_m)
        nodes, weights = np.polynomial.legendre.leggauss(8)
        knots = np.linspace(-1.0, 1.0, KNOTS)
        half = 1.0 / (KNOTS - 1)
        inner = (knots[:-1] + half)[:, None] + half * nodes
        pieces = np.linalg.norm(chebyshev.chebval(inner, derivative), axis=0) @ weights * half
        slopes = 1.0 / np.linalg.norm(chebyshev.chebval(knots, derivative), axis=0)
        return [0.0, *np.cumsum(pieces).tolist()], slopes.tolist()

    @cached_property
    def _series(self) -> tuple[list[float], list[float]]:
        x, y = self.series_m.T.tolist()
        return x, y


def _value(series: list[float], u: float) -> float:
    """Return the value of a Chebyshev series, by Clenshaw's recurrence."""
    last = before = 0.0
    for coefficient in series[:0:-1]:
        last, before = 2 * u * last - before + coefficient, last
    return u * last - before + series[0]
