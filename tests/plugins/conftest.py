"""Local maps drawn by hand."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from graphnav import LocalMap
from graphnav.arrays import Bools, Doubles

Where = Callable[[Doubles, Doubles], Bools]
DrawMap = Callable[..., LocalMap]


def _nowhere(x_m: Doubles, y_m: Doubles) -> Bools:  # the signature of places
    return np.zeros(x_m.shape, np.bool_)


@pytest.fixture
def draw_map() -> DrawMap:
    """Return what makes a square map around the origin of functions that say where what is."""

    def draw(
        obstacle: Where = _nowhere,
        unknown: Where = _nowhere,
        pose: tuple[float, float, float] = (0.0, 0.0, 0.0),
        moving: Where = _nowhere,
        half_m: float = 2.0,
        cell_m: float = 0.05,
    ) -> LocalMap:
        middles = np.arange(-round(half_m / cell_m), round(half_m / cell_m) + 1) * cell_m
        x_m, y_m = np.meshgrid(middles, middles)
        state = np.full(x_m.shape, LocalMap.FREE, np.uint8)
        state[unknown(x_m, y_m)] = LocalMap.UNKNOWN
        state[obstacle(x_m, y_m)] = LocalMap.OBSTACLE
        state[moving(x_m, y_m)] = LocalMap.MOVING
        origin_m = float(middles[0])
        return LocalMap(cell_m, origin_m, origin_m, *pose, state)

    return draw
