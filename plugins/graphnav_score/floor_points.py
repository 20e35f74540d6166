"""Where on the floor plan the cells of a camera's picture are, from their depth."""

from __future__ import annotations

import math

import numpy as np

from graphnav import Map, Truth
from graphnav.arrays import Bools, Doubles, Indices

_MIN_GROUND_CELLS = 10


def floor_points_m(truth: Truth, world: Map, factor: int) -> Doubles | None:
    """Return the floor plan position in the robot's frame of what the middle of each cell shows, (rows, cols, 2).

    Zero above the horizon; None where too little of the picture is ground to tell how the camera looks. ``factor``:
    the truth's rows in one row of cells.

    Of the camera, which is above the robot's middle and not rolled, only `Map.footprint_m` is known. Over the
    ground the inverse of depth is ``cos t / (h f) (y - y_0) + sin t / h``, t the tilt and h the height, so that a line
    fitted to the true depth of the ground and the width of the footprint at the picture's lower edge give f, t and h.

    The footprint is that of the camera at rest. One that shakes has another, which displaces the points: root mean
    squares for a camera 1 m above level ground, tilted by 75 degrees, are 17 mm if it bobs by 3 % of its height, 9 mm
    if it rolls by 0.5 degrees, 1 mm if it pitches by 0.5 degrees; each grows in proportion.
    """
    rows, cols = truth.depth_m.shape
    at_y, at_x = cell_middles(rows, factor), cell_middles(cols, factor)
    cells = np.ix_(at_y, at_x)
    z_m = truth.depth_m[cells].astype(np.float64)
    is_below = np.isfinite(z_m)
    z_m[~is_below] = 0.0
    y = at_y - (rows - 1) / 2
    line = _line(np.broadcast_to(y[:, None], z_m.shape), z_m, is_below & (truth.obstacle[cells] == 0))
    if line is None:
        return None
    slope, middle = line
    half_width_m = abs(float(world.footprint_m[0, 1]))
    focal_px = cols / 2 / ((slope * rows / 2 + middle) * half_width_m)
    height_m = 1 / math.hypot(slope * focal_px, middle)
    cos_tilt, sin_tilt = slope * focal_px * height_m, middle * height_m
    forward = z_m * (cos_tilt - sin_tilt * y[:, None] / focal_px)
    return np.dstack([forward, -z_m * (at_x - (cols - 1) / 2) / focal_px])


def cell_middles(size: int, factor: int) -> Indices:
    """Return the middle row of each cell of ``factor`` rows out of ``size``; the last cell may be cut."""
    return np.minimum(np.arange(0, size, factor) + factor // 2, size - 1)


def _line(y: Doubles, z_m: Doubles, ground: Bools) -> tuple[float, float] | None:
    """Return slope and value at 0 of the line through the inverse depths where ``ground``, None if it has none."""
    at, inverse = y[ground], 1 / z_m[ground]
    if len(at) < _MIN_GROUND_CELLS or not np.ptp(at):
        return None
    away = at - at.mean()
    slope = float(away @ inverse) / float(away @ away)
    return slope, float(inverse.mean() - slope * at.mean())
