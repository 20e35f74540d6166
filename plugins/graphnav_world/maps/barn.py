"""A world of the BARN challenge: cylinders on a grid, the robot's start, a round goal."""

from __future__ import annotations

import math
from functools import lru_cache
from pathlib import Path

import numpy as np

from graphnav.arrays import Bools
from graphnav_world.geometry import outlines
from graphnav_world.geometry.scene import Body
from graphnav_world.maps.corridor import Corridor
from graphnav_world.maps.corridor_keys import N_WORLDS, BarnKeys
from graphnav_world.maps.draws import Draws

CYLINDERS = Path(__file__).with_name("barn_cylinders.npz")
CELL_M = 0.15
FIRST_M = (-4.425, 0.075)
"""The centre of the cylinder in the first column and row."""
RADIUS_M = 0.075
START = (-2.25, 3.0, math.pi / 2)
GOAL_M = (-2.25, 13.0)
GOAL_RADIUS_M = 1.0
GOAL_SIDES = 180
"""Of the goal's outline, which leaves the circle by at most 0.2 mm."""


def draw_barn(draws: Draws, keys: BarnKeys) -> Corridor:
    """Return a world with its start and its goal: by number, or that of the run's seed."""
    number = draws.count(keys.world) if keys.world is not None else draws.run_seed % N_WORLDS
    height_m = draws.number(keys.height_m)
    cells = np.argwhere(_cylinders()[number])
    centres = np.array(FIRST_M) + CELL_M * cells
    cylinders = [Body.prism(outlines.circle(x, y, RADIUS_M), height_m, keys.texture) for x, y in centres.tolist()]
    return Corridor(cylinders, START, outlines.circle(*GOAL_M, GOAL_RADIUS_M, GOAL_SIDES))


@lru_cache(maxsize=1)
def _cylinders() -> Bools:
    """Return which cells have a cylinder, (worlds, columns, rows)."""
    with np.load(CYLINDERS) as stored:
        shape = stored["shape"]
        return np.unpackbits(stored["cylinders"])[: shape.prod()].reshape(shape).astype(bool)
