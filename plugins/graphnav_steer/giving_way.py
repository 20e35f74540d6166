"""Out of the way of what moves, straight on or straight back."""

from __future__ import annotations

import math

import numpy as np

from graphnav import LocalMap
from graphnav_steer.local_paths import cell_below


def out_of_the_way_rad(map: LocalMap, clear_m: float, reach_m: float) -> float | None:  # noqa: A002  # the port's name
    """Return 0 or pi, whether straight on or straight back the robot is sooner out of the way of what moves.

    None if nothing that moves is expected nearer to its centre than ``clear_m``, or neither way gets as far from all
    obstacles within ``reach_m``, over known floor and without coming nearer to one.
    """
    if not _is_in_the_way(map, clear_m):
        return None
    steps_m = map.cell_m / 2 * np.arange(1, math.ceil(2 * reach_m / map.cell_m) + 1)
    found: dict[float, float] = {}
    for theta_rad in (0.0, math.pi):
        ahead_m = np.asarray(math.cos(theta_rad) * steps_m, np.float64)
        near_m = map.obstacle_m_at(ahead_m, np.zeros_like(steps_m))
        blocked = map.unknown_m_at(ahead_m, np.zeros_like(steps_m)) <= 0.0
        blocked |= np.diff(near_m, prepend=near_m[0]) < 0.0
        clear = near_m >= clear_m
        first = int(np.argmax(clear))
        if clear.any() and not blocked[: first + 1].any():
            found[theta_rad] = float(steps_m[first])
    return min(found, key=found.__getitem__) if found else None


def _is_in_the_way(map: LocalMap, clear_m: float) -> bool:  # noqa: A002  # the port's name
    row, col = cell_below(map)
    reach = math.ceil(clear_m / map.cell_m) + 1
    top, left = max(row - reach, 0), max(col - reach, 0)
    is_moving = map.state[top : row + reach + 1, left : col + reach + 1] == LocalMap.MOVING
    if not is_moving.any():
        return False
    rows, cols = np.nonzero(is_moving)
    x_m, y_m = map.places_m(rows + top, cols + left)
    return bool((np.hypot(x_m - map.x_m, y_m - map.y_m) < clear_m).any())
