"""The picture of a local map: free white, unknown gray, obstacles red, what moves orange, and the robot."""

from __future__ import annotations

import math

import cv2
import numpy as np

from graphnav import LocalMap
from graphnav.arrays import Bytes
from graphnav_view import style

_SHIFT = 4
"""Fractional bits of pixel coordinates."""
_ROBOT_RATIO = 0.025
"""Radius of the robot's mark as a share of the picture; the map does not know the robot's size."""
UNKNOWN = "#9a9a9a"
"""Colour of unknown floor."""
_COLOURS = np.array([style.rgb(UNKNOWN), (255, 255, 255), style.rgb(style.CONTACT), style.rgb("#f0a030")], np.uint8)
"""Of the states 0 unknown, 1 free, 2 obstacle, 3 moving."""
_LEVELS = np.repeat(np.array([[0], [110], [255], [190]], np.uint8), 3, axis=1)


def draw_local_map(local: LocalMap, rows: int, cols: int, *, with_colour: bool = True) -> Bytes:
    """Return the map as (rows, cols, 3) RGB, x to the right and y up; without colour brightness tells obstacles.

    States other than those of `LocalMap` are drawn as unknown.
    """
    known = np.where(local.state <= LocalMap.MOVING, local.state, np.uint8(LocalMap.UNKNOWN))
    cells = (_COLOURS if with_colour else _LEVELS)[known[::-1]]
    picture: Bytes = cv2.resize(np.ascontiguousarray(cells), (cols, rows), interpolation=cv2.INTER_NEAREST)
    _draw_robot(picture, local)
    return picture


def _draw_robot(picture: Bytes, local: LocalMap) -> None:
    rows, cols = picture.shape[:2]
    grid_rows, grid_cols = local.state.shape
    if local.cell_m <= 0.0:
        return
    # The middle of the first cell is half a cell from the picture's rim.
    right = ((local.x_m - local.origin_x_m) / local.cell_m + 0.5) / grid_cols
    up = ((local.y_m - local.origin_y_m) / local.cell_m + 0.5) / grid_rows
    if not (0.0 <= right <= 1.0 and 0.0 <= up <= 1.0):
        return
    radius = max(2.0, _ROBOT_RATIO * min(rows, cols))
    centre = np.array([right * cols, (1.0 - up) * rows]) - 0.5
    nose = centre + 2.0 * radius * np.array([math.cos(local.yaw_rad), -math.sin(local.yaw_rad)])
    middle, tip = (np.rint(point * 2**_SHIFT).astype(int).tolist() for point in (centre, nose))
    colour, width = style.rgb(style.ROBOT), max(1, round(radius / 4))
    cv2.circle(picture, middle, round(radius * 2**_SHIFT), style.rgb(style.SEEN), -1, cv2.LINE_AA, _SHIFT)
    cv2.circle(picture, middle, round(radius * 2**_SHIFT), colour, width, cv2.LINE_AA, _SHIFT)
    cv2.line(picture, middle, tip, colour, width, cv2.LINE_AA, _SHIFT)
