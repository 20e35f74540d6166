"""The picture and the exact truth of a camera over a floor with upright bodies."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import cv2
import numpy as np

from graphnav.arrays import Bytes, Doubles, Floats, Ints
from graphnav_world.geometry.scene import Faces
from graphnav_world.rendering.atlas import Atlas
from graphnav_world.rendering.body_texture import BodyTexture
from graphnav_world.rendering.camera import Camera
from graphnav_world.rendering.film import Film
from graphnav_world.rendering.floor import Floor
from graphnav_world.rendering.lighting import Lighting
from graphnav_world.rendering.neutral import NeutralTexture
from graphnav_world.rendering.placed_faces import Placed
from graphnav_world.rendering.visibility import Visible, ZBuffer

FLOOR = -1
MIN_DEPTH_RATIO = np.float32(1e-6)
"""Minimum of a point's former depth over the present one: flow stays finite."""


@dataclass(frozen=True)
class Frame:
    """The gray values of a picture and its ground truth, which is computed where it is asked for.

    ``gray``: float32 (rows, cols), the sum of all views. ``seen``: what is seen of bodies. ``floor_inverse_depth``:
    float32 (rows, cols), as if there were none. ``flow``: takes inverse depth to flow, None for a first frame.
    """

    gray: Floats
    views: int
    seen: Visible
    floor_inverse_depth: Floats
    flow: Callable[[Floats], Floats] | None

    @property
    def pixels(self) -> Bytes:
        """The picture in light as the map's, without noise: uint8 (rows, cols)."""
        return Film().exposed(self.gray, self.views)

    @cached_property
    def inverse_depth(self) -> Floats:
        """Inverse of the depth along the optical axis, float32 (rows, cols), 1/m, 0 above the horizon."""
        return _inverse_depth(self.floor_inverse_depth, self.seen)

    @property
    def depth_m(self) -> Floats:
        """Depth along the optical axis, float32 (rows, cols), infinite above the horizon."""
        with np.errstate(divide="ignore"):
            return np.reciprocal(self.inverse_depth)

    @property
    def flow_px(self) -> Floats | None:
        """Displacement of every pixel's surface point, right and down, float32 (rows, cols, 2); None at first."""
        return None if self.flow is None else self.flow(self.inverse_depth)

    @property
    def obstacle(self) -> Bytes:
        """Where a body is seen: uint8 (rows, cols), 1 there."""
        obstacle = np.zeros(self.gray.shape, np.uint8)
        obstacle.reshape(-1)[self.seen.pixel] = 1
        return obstacle

    @property
    def surface(self) -> Ints:
        """Which face is seen: int32 (rows, cols), -1 for the floor and above the horizon."""
        face = np.full(self.gray.shape, FLOOR, np.int32)
        face.reshape(-1)[self.seen.pixel] = self.seen.pixel_face
        return face


class Renderer:
    """Renders one world.

    ``floor_origin_m``: the world point where the floor's texture begins. ``lighting``: None for uniform light.
    ``neutral``: draws all surfaces in place of their textures. Everything is computed from the same exact hits of pixel
    rays and planes: texture coordinates, depth and flow.
    """

    def __init__(
        self,
        camera: Camera,
        faces: Faces,
        atlas: Atlas,
        floor_origin_m: Doubles,
        *,
        lighting: Lighting | None = None,
        neutral: NeutralTexture | None = None,
    ) -> None:
        self._zbuffer = ZBuffer(camera)
        self._floor = Floor(camera, atlas, floor_origin_m)
        self._texture = BodyTexture(camera, faces, atlas)
        self._flow = TrueFlow(camera, faces)
        self._lighting, self._neutral = lighting, neutral

    def render(
        self,
        now: Placed,
        before: Placed | None,
        *,
        meanwhile: Sequence[Placed] = (),
        rows: range | None = None,
    ) -> Frame:
        """Return the frame seen from ``now``, with the flow since ``before``.

        ``meanwhile``: other camera poses while the shutter was open; the picture is the mean of all, the rest is of
        ``now`` alone. ``rows``: of the picture, if it is not all that is wanted.
        """
        seen = self._zbuffer.find(now, rows)
        gray = self._gray(now, seen, rows)
        for moment in meanwhile:
            gray += self._gray(moment, self._zbuffer.find(moment, rows), rows)
        first_row = 0 if rows is None else rows.start
        flow = None if before is None else partial(self._flow.between, now, before, seen, first_row)
        return Frame(gray, 1 + len(meanwhile), seen, self._floor.inverse_depth(now, rows), flow)

    def _gray(self, placed: Placed, seen: Visible, rows: range | None) -> Floats:
        """Return the gray values before brightness and noise, float32 (rows, cols)."""
        gray = self._floor.gray(placed, rows) if self._neutral is None else self._neutral.gray(placed, rows)
        if len(seen.pixel) and self._neutral is None:
            gray.reshape(-1)[seen.pixel] = self._texture.gray(placed, seen)
        if self._lighting is not None:
            inverse_depth = _inverse_depth(self._floor.inverse_depth(placed, rows), seen)
            self._lighting.apply(gray, placed, seen, inverse_depth, 0 if rows is None else rows.start)
        return gray


def _inverse_depth(of_floor: Floats, seen: Visible) -> Floats:
    inverse = of_floor.copy()
    inverse.reshape(-1)[seen.pixel] = seen.inverse_depth
    return inverse


class TrueFlow:
    """Computes flow from inverse depth, of which a point's former position is a linear function at each pixel."""

    def __init__(self, camera: Camera, faces: Faces) -> None:
        self._focal_px, self._faces = np.float32(camera.focal_px), faces
        rays = camera.rays().astype(np.float32)
        self._x, self._y = rays[0, :, 0], rays[:, :1, 1]
        self._from_center_x, self._from_center_y = (self._focal_px * one for one in (self._x, self._y))

    def between(self, now: Placed, before: Placed, seen: Visible, first_row: int, inverse_depth: Floats) -> Floats:
        """Return the displacement of every pixel's surface point since ``before``, float32 (rows, cols, 2)."""
        rows = slice(first_row, first_row + len(inverse_depth))
        matrix = before.camera_from(now).astype(np.float32)
        past = [x * self._x + (y * self._y[rows] + one) for x, y, one, _ in matrix]
        for axis, shift in enumerate(matrix[:, 3]):
            past[axis] += inverse_depth * shift
        for body, moved_W in now.moved_since(before):
            of_body = np.flatnonzero(self._faces.body.take(seen.pixel_face) == body)
            at, inverse = seen.pixel.take(of_body), seen.inverse_depth.take(of_body)
            for axis, moved in enumerate((before.R_WC.T @ moved_W).astype(np.float32)):
                past[axis].reshape(-1)[at] -= inverse * moved
        per_depth = self._focal_px / np.maximum(past[2], MIN_DEPTH_RATIO, out=past[2])
        for axis, from_center in enumerate((self._from_center_x, self._from_center_y[rows])):
            past[axis] *= per_depth
            np.subtract(from_center, past[axis], out=past[axis])
        flow: Floats = cv2.merge(past[:2])
        return flow
