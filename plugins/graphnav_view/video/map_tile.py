"""The map tile of the video: the world from above, the robot and the path so far."""

from __future__ import annotations

import math

import cv2
import numpy as np

from graphnav import Scene, SceneArea, State
from graphnav.arrays import Bytes, Doubles, Ints
from graphnav_view import style
from graphnav_view.video.lettering import write

_SHIFT = 4
"""Fractional bits of pixel coordinates of lines."""
_MARGIN_M = 0.25
_SMALL_PX = 160
"""In a smaller view lines are thin and the robot is drawn nearer to its own size."""


class TopView:
    """Draws the map with the path, x to the right and y up.

    ``path_m`` (n, 2) and ``moving`` (n, m, 3), poses of the moving obstacles: content that must be in view besides the
    world.
    """

    def __init__(
        self, scene: Scene, path_m: Doubles, moving: Doubles, cols: int, rows: int, *, with_scale: bool = True
    ) -> None:
        self._scene = scene
        low, high = scene.bounds_m([path_m], moving, _MARGIN_M)
        self._per_m = float(np.min(np.array([cols, rows]) / (high - low)))
        self._middle_m, self._middle_px = (low + high) / 2, np.array([cols, rows]) / 2
        is_small = min(cols, rows) < _SMALL_PX
        self._line_px, self._min_radius_px = (1, 2) if is_small else (2, 4)
        self._ground = self._background(cols, rows)
        if with_scale:
            draw_scale_bar(self._ground, self._per_m)

    def draw(self, state: State | None, path_m: Doubles) -> Bytes:
        """Return the tile, (rows, cols, 3) RGB: the world, and the robot in ``state`` with its path so far."""
        if state is None:
            return self._ground
        tile = self._ground.copy()
        pose = np.array([state.x_m, state.y_m, state.yaw_rad])
        for area in (*self._scene.moving_at(state.moving), *self._scene.seen_at(pose)):
            self._fill(tile, area)
        trace = self._to_px(path_m)[:, None]
        cv2.polylines(tile, [trace], False, style.rgb(style.ROBOT), self._line_px, cv2.LINE_AA, _SHIFT)  # noqa: FBT003 - OpenCV's own order
        self._robot(tile, pose, contact=state.contact)
        return tile

    def _robot(self, tile: Bytes, pose: Doubles, *, contact: bool) -> None:
        centre = self._to_px(pose[None, :2])[0]
        radius = max(round(self._scene.robot_radius_m * self._per_m * 2**_SHIFT), self._min_radius_px << _SHIFT)
        colour = style.rgb(style.CONTACT if contact else style.ROBOT)
        if self._scene.robot is None or radius == self._min_radius_px << _SHIFT:
            cv2.circle(tile, centre.tolist(), radius, (255, 255, 255), -1, cv2.LINE_AA, _SHIFT)
            cv2.circle(tile, centre.tolist(), radius, colour, self._line_px, cv2.LINE_AA, _SHIFT)
        else:
            outline = self._to_px(self._scene.robot.at(pose).outline_m)[:, None]
            cv2.fillPoly(tile, [outline], (255, 255, 255), cv2.LINE_AA, _SHIFT)
            cv2.polylines(tile, [outline], True, colour, self._line_px, cv2.LINE_AA, _SHIFT)  # noqa: FBT003 - OpenCV's own order
        nose = centre + np.round(radius * np.array([math.cos(pose[2]), -math.sin(pose[2])])).astype(np.int32)
        cv2.line(tile, centre.tolist(), nose.tolist(), colour, self._line_px, cv2.LINE_AA, _SHIFT)

    def _background(self, cols: int, rows: int) -> Bytes:
        tile = np.full((rows, cols, 3), style.rgb(style.FLOOR), np.uint8)
        for area in self._scene.fixed:
            self._fill(tile, area)
        return tile

    def _fill(self, tile: Bytes, area: SceneArea) -> None:
        below = tile.copy() if area.opacity_ratio < 1 else tile
        cv2.fillPoly(tile, [self._to_px(area.outline_m)[:, None]], style.rgb(area.colour), cv2.LINE_AA, _SHIFT)
        if below is not tile:
            cv2.addWeighted(tile, area.opacity_ratio, below, 1 - area.opacity_ratio, 0, dst=tile)

    def _to_px(self, points_m: Doubles) -> Ints:
        """Return points of W in the tile's pixels, times 2**_SHIFT."""
        away = (points_m - self._middle_m) * self._per_m * np.array([1.0, -1.0])
        return np.asarray(np.round((away + self._middle_px) * 2**_SHIFT), np.int32)


def draw_scale_bar(tile: Bytes, per_m: float) -> None:
    """Draw a scale of one metre into the lower left corner, on its own background; ``per_m``: pixels a metre."""
    length, low = round(per_m), tile.shape[0] - 12
    write(tile, "1 m", (12, low - 6), (20, 20, 20), ground=style.rgb(style.FLOOR))
    cv2.line(tile, (12, low), (12 + length, low), (20, 20, 20), 3)


def view_size_px(scene: Scene, path_m: Doubles, moving: Doubles, cols: int, rows: int) -> tuple[int, int]:
    """Return columns and rows of a view with the world's shape that fills ``cols`` x ``rows`` in one direction."""
    low, high = scene.bounds_m([path_m], moving, _MARGIN_M)
    wide, high_m = (high - low).tolist()
    per_m = min(cols / wide, rows / high_m)
    return max(1, min(cols, round(wide * per_m))), max(1, min(rows, round(high_m * per_m)))
