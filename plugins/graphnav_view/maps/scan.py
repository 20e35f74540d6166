"""The picture of a scan: what its beams hit around the robot, and the floor that they pass over."""

from __future__ import annotations

import cv2
import numpy as np

from graphnav import Scan
from graphnav.arrays import Bytes
from graphnav_view import style
from graphnav_view.maps.local_map import UNKNOWN
from graphnav_view.video.map_tile import draw_scale_bar

_SHIFT = 4
"""Fractional bits of pixel coordinates."""
_SHOWN_M = 5.0
"""Distance that is shown at most: of a lidar that reaches far the surroundings count."""
_MIN_SHOWN_M = 1e-3
_ROBOT_RATIO = 0.025
"""Radius of the robot's mark as a share of the picture; a scan does not know the robot's size."""


def draw_scan(scan: Scan, side: int, *, with_scale: bool) -> Bytes:
    """Return a scan as (side, side, 3) RGB: forward is up, the robot in the middle; unknown floor is gray."""
    reach_m = max(min(scan.range_max_m, _SHOWN_M), _MIN_SHOWN_M)
    per_m = side / (2 * reach_m)
    picture = np.full((side, side, 3), style.rgb(UNKNOWN), np.uint8)
    _fill_free(picture, scan, per_m)
    points = scan.points_m()
    rows, cols = np.rint((side - 1) / 2 - per_m * points).astype(np.int64).T
    radius = side // 200
    for row, col in {(int(row), int(col)) for row, col in zip(rows, cols, strict=True)}:
        if 0 <= row < side and 0 <= col < side:
            cv2.circle(picture, (col, row), radius, style.rgb(style.CONTACT), -1)
    _draw_robot(picture, side)
    if with_scale:
        draw_scale_bar(picture, per_m)
    return picture


def _fill_free(picture: Bytes, scan: Scan, per_m: float) -> None:
    """Fill the wedge between each two neighbouring beams up to the nearer end of both."""
    side, angles, free_m = len(picture), scan.angles_rad(), scan.free_m()
    middle = (side - 1) / 2
    near = np.minimum(per_m * np.minimum(free_m[:-1], free_m[1:]), 2 * side)
    corners = [
        np.stack([middle - near * np.sin(a), middle - near * np.cos(a)], axis=1) for a in (angles[:-1], angles[1:])
    ]
    wedges = np.stack([np.full_like(corners[0], middle), *corners], axis=1)
    for wedge in np.rint(wedges * 2**_SHIFT).astype(np.int32):
        cv2.fillConvexPoly(picture, wedge, (255, 255, 255), cv2.LINE_8, _SHIFT)


def _draw_robot(picture: Bytes, side: int) -> None:
    radius = max(2, round(_ROBOT_RATIO * side))
    middle, width = (side - 1) // 2, max(1, radius // 4)
    colour = style.rgb(style.ROBOT)
    cv2.circle(picture, (middle, middle), radius, style.rgb(style.SEEN), -1, cv2.LINE_AA)
    cv2.circle(picture, (middle, middle), radius, colour, width, cv2.LINE_AA)
    cv2.line(picture, (middle, middle), (middle, middle - 2 * radius), colour, width, cv2.LINE_AA)
