"""The floor in the picture: its texture at every pixel, as if there were no bodies."""

from __future__ import annotations

import cv2
import numpy as np

from graphnav.arrays import Doubles, Floats
from graphnav_world.rendering.atlas import Atlas
from graphnav_world.rendering.camera import Camera
from graphnav_world.rendering.floor_view import FloorView
from graphnav_world.rendering.placed_faces import Placed

SKY_GRAY = 255


class Floor:
    """Draws the floor; ``origin_m``: the world point where its texture begins.

    What follows from the camera's tilt, roll and height alone is computed once for the camera at rest, and again for
    every frame of a camera that shakes.
    """

    def __init__(self, camera: Camera, atlas: Atlas, origin_m: Doubles) -> None:
        self._atlas, self._origin_m = atlas, origin_m
        self._at_rest = self._shaken = FloorView.of(camera, atlas)

    def inverse_depth(self, now: Placed) -> Floats:
        """Return 1/m along the optical axis, float32 (rows, cols), 0 above the horizon."""
        return self._view(now).inverse_depth

    def gray(self, now: Placed) -> Floats:
        """Return the gray values before light and noise, float32 (rows, cols)."""
        view = self._view(now)
        fine_px, coarse_px = self._places(now, view)
        fine = cv2.remap(self._atlas.pixels, fine_px, None, cv2.INTER_LINEAR)
        coarse = cv2.remap(self._atlas.pixels, coarse_px, None, cv2.INTER_LINEAR)
        gray: Floats = cv2.subtract(coarse, fine, dtype=cv2.CV_32F)
        gray *= view.blend
        gray += fine
        if len(view.sky):
            gray.reshape(-1)[view.sky] = SKY_GRAY
        return gray

    def _view(self, now: Placed) -> FloorView:
        if now.camera == self._at_rest.camera:
            return self._at_rest
        if now.camera != self._shaken.camera:
            self._shaken = FloorView.of(now.camera, self._atlas)
        return self._shaken

    def _places(self, now: Placed, view: FloorView) -> tuple[Floats, Floats]:
        """Return the atlas position of every pixel's floor point, (rows, cols, 2), on the finer and coarser level."""
        c, s = now.heading
        period = self._atlas.period_m[0]
        x, y = (now.eye_W[:2] - self._origin_m) % period
        place: Floats = cv2.transform(view.place_R, np.array([[c, -s, x], [s, c, y]]))
        reach_m = view.reach_m
        if min(x, y) < reach_m or x + reach_m > period[0] or y + reach_m > period[1]:
            place -= np.floor(place / period) * period
        place *= view.per_m
        place += view.fine_px
        coarse = place * np.float32(0.5)
        coarse += view.coarse_px
        return place, coarse
