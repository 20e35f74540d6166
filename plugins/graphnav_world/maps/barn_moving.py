"""A world of cylinders that move on polynomials, by the method of DynaBARN, between the start and the goal of BARN."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import chebyshev

from graphnav.arrays import Doubles
from graphnav_world.geometry import outlines
from graphnav_world.geometry.polynomial_path import PolynomialPath
from graphnav_world.geometry.scene import Body
from graphnav_world.maps.barn import GOAL_M, GOAL_RADIUS_M, GOAL_SIDES, START
from graphnav_world.maps.corridor import Corridor
from graphnav_world.maps.corridor_keys import N_MOVING_WORLDS, BarnMovingKeys
from graphnav_world.maps.draws import Draws

RADIUS_M = 0.25
FIELD_M = np.array([[-4.5, 4.5], [0.0, 11.5]])
"""Its corners: as wide as BARN's, and as long as fits between the start and the goal."""
SWING_S = (3.0, 9.0)
"""The period in which a speed rises and falls."""
MAX_SWING = 0.9
"""Of the mean speed: no cylinder stands, or moves backwards, but where it turns."""
MIN_BEND_M, FLATTER = 0.4, 0.9
"""The sharpest bend that a path may have, and by how much the polynomial of one that is sharper is scaled, again and
again: a cylinder of 1.4 m/s goes round it at 5 m/s²."""


@dataclass(frozen=True)
class Grade:
    """From where to where the numbers of a world's cylinders are drawn."""

    count: tuple[int, int]
    order: tuple[int, int]
    mean_mps: tuple[float, float]
    deviation_mps: tuple[float, float]

    @property
    def max_mps(self) -> float:
        """The speed that no cylinder exceeds."""
        return self.mean_mps[1] + math.sqrt(2) * self.deviation_mps[1]


GRADES = (
    Grade(count=(3, 6), order=(1, 2), mean_mps=(0.1, 0.3), deviation_mps=(0.0, 0.05)),
    Grade(count=(5, 9), order=(2, 4), mean_mps=(0.3, 0.6), deviation_mps=(0.05, 0.15)),
    Grade(count=(8, 12), order=(3, 6), mean_mps=(0.6, 1.0), deviation_mps=(0.1, 0.3)),
)
"""Easy, medium, hard: as many worlds of each."""


def draw_barn_moving(draws: Draws, keys: BarnMovingKeys) -> Corridor:
    """Return a world with its start and its goal: by number, or that of the run's seed."""
    number = draws.count(keys.world) if keys.world is not None else draws.run_seed % N_MOVING_WORLDS
    height_m = draws.number(keys.height_m)
    outline = outlines.circle(0.0, 0.0, RADIUS_M)
    cylinders = [
        Body.prism(outline, height_m, keys.texture, path) for path in paths(draws.count(keys.collection), number)
    ]
    return Corridor(cylinders, START, outlines.circle(*GOAL_M, GOAL_RADIUS_M, GOAL_SIDES))


def grade_of(number: int) -> Grade:
    """Return how difficult the world of a number is."""
    return GRADES[number * len(GRADES) // N_MOVING_WORLDS]


def paths(collection: int, number: int) -> list[PolynomialPath]:
    """Return how the cylinders of a world move."""
    rng, grade = np.random.default_rng([collection, number]), grade_of(number)
    return [_path(rng, grade) for _ in range(rng.integers(*grade.count, endpoint=True))]


def _path(rng: np.random.Generator, grade: Grade) -> PolynomialPath:
    """Return a path from side to side of the field, or along it, whose other coordinate is a polynomial."""
    order = int(rng.integers(*grade.order, endpoint=True))
    low_m, high_m = FIELD_M[0] + RADIUS_M, FIELD_M[1] - RADIUS_M
    along, across = rng.permutation(2)
    series_m = np.zeros((order + 1, 2))
    series_m[:2, along] = np.array([low_m + high_m, high_m - low_m])[:, along] / 2
    waypoints_m = rng.uniform(low_m[across], high_m[across], order + 1)
    fitted = chebyshev.chebfit(chebyshev.chebpts2(order + 1), waypoints_m, order)
    series_m[:, across] = within(np.asarray(fitted, np.float64), low_m[across], high_m[across])
    mean_mps = rng.uniform(*grade.mean_mps)
    path = PolynomialPath(
        series_m,
        mean_mps,
        swing_mps=min(math.sqrt(2) * rng.uniform(*grade.deviation_mps), MAX_SWING * mean_mps),
        swing_s=rng.uniform(*SWING_S),
        phase_rad=rng.uniform(0.0, 2 * math.pi),
        ahead_m=rng.uniform(0.0, 100.0),
    )
    while path.sharpest_m < MIN_BEND_M:
        flatter_m = path.series_m.copy()
        flatter_m[1:, across] *= FLATTER
        path = replace(path, series_m=flatter_m)
    return path


def within(series: Doubles, low: float, high: float) -> Doubles:
    """Return a Chebyshev series, (n,), scaled and moved into these bounds if it leaves them between -1 and 1."""
    turns = chebyshev.chebroots(chebyshev.chebder(series)) if len(series) > 2 else np.zeros(0)
    turns = turns.real[(np.abs(turns.imag) < 1e-9) & (np.abs(turns.real) < 1.0)]
    values = chebyshev.chebval(np.concatenate([[-1.0, 1.0], turns]), series)
    min_value, max_value = values.min(), values.max()
    if low <= min_value and max_value <= high:
        return series
    scale = min(1.0, (high - low) / (max_value - min_value))
    scaled: Doubles = series * scale
    scaled[0] += max(low - min_value * scale, 0.0) - max(max_value * scale - high, 0.0)
    return scaled
