"""The true displacement of every pixel's surface point."""

from __future__ import annotations

import cv2
import numpy as np

from graphnav.arrays import Floats
from graphnav_world.geometry.scene import Faces
from graphnav_world.rendering.camera import Camera
from graphnav_world.rendering.placed_faces import Placed
from graphnav_world.rendering.visibility import Visible

NEAREST = np.float32(1e-6)


class TrueFlow:
    """Computes flow from inverse depth, of which a point's former position is a linear function at each pixel."""

    def __init__(self, camera: Camera, faces: Faces) -> None:
        self._focal_px, self._faces = np.float32(camera.focal_px), faces
        rays = camera.rays().astype(np.float32)
        self._x, self._y = rays[0, :, 0], rays[:, :1, 1]
        self._from_center_x, self._from_center_y = (self._focal_px * one for one in (self._x, self._y))

    def between(self, now: Placed, before: Placed, seen: Visible, inverse_depth: Floats) -> Floats:
        """Return the displacement of every pixel's surface point since ``before``, float32 (rows, cols, 2)."""
        matrix = before.camera_from(now).astype(np.float32)
        past = [x * self._x + (y * self._y + one) for x, y, one, _ in matrix]
        for axis, shift in enumerate(matrix[:, 3]):
            past[axis] += inverse_depth * shift
        for body, moved_W in now.moved_since(before):
            of_body = np.flatnonzero(self._faces.body.take(seen.pixel_face) == body)
            at, inverse = seen.pixel.take(of_body), seen.inverse_depth.take(of_body)
            for axis, moved in enumerate((before.R_WC.T @ moved_W).astype(np.float32)):
                past[axis].reshape(-1)[at] -= inverse * moved
        per_depth = self._focal_px / np.maximum(past[2], NEAREST, out=past[2])
        for axis, from_center in enumerate((self._from_center_x, self._from_center_y)):
            past[axis] *= per_depth
            np.subtract(from_center, past[axis], out=past[axis])
        flow: Floats = cv2.merge(past[:2])
        return flow
