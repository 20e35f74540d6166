"""The picture and the exact truth of a camera over a floor with upright bodies."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from graphnav.arrays import Bytes, Doubles, Floats, Ints
from graphnav_world.geometry.scene import Faces
from graphnav_world.rendering.atlas import MAX_LEVELS, MIN_LEVELS, Atlas
from graphnav_world.rendering.camera import Camera
from graphnav_world.rendering.noise import normal_noise
from graphnav_world.rendering.placed_faces import Placed
from graphnav_world.rendering.textures import TEXEL_M
from graphnav_world.rendering.visibility import FLOOR, Visible, ZBuffer

STRETCH = 2.0
"""How much longer than wide a pixel's print on a surface may be before the texture is blurred along with it."""


def level_count(camera: Camera) -> int:
    """Return the number of mip levels that prevent aliasing of the floor in this camera."""
    rays = camera.rays()
    depth = camera.height_m / np.maximum(rays @ -camera.R_RC[2], 1e-3)
    long_m = depth**2 * np.square(rays).sum(axis=-1) / (camera.focal_px * camera.height_m * STRETCH)
    needed = math.ceil(math.log2(long_m.max() / TEXEL_M)) + 1
    return min(max(needed, MIN_LEVELS), MAX_LEVELS)


@dataclass(frozen=True)
class Frame:
    """A picture and its ground truth.

    ``pixels``: uint8 (rows, cols), gray. ``face``: int32 (rows, cols), -1 for the floor and above the horizon.
    ``depth_m``: float32 (rows, cols), along the optical axis, infinite above the horizon. ``obstacle``: uint8 (rows,
    cols), 1 where a body is seen. ``flow_px``: float32 (rows, cols, 2), right and down, or None for a first frame.
    """

    pixels: Bytes
    face: Ints
    depth_m: Floats
    obstacle: Bytes
    flow_px: Floats | None


@dataclass(frozen=True)
class _View:
    """The view of one pose: flat arrays of the pixels, of which ``bodies`` are not floor, and gray (rows, cols)."""

    seen: Visible
    face: Ints
    bodies: npt.NDArray[np.intp]
    depth: Floats
    gray: Floats


class Renderer:
    """Renders one world.

    ``floor_origin_m``: the world point where the floor's texture begins. Everything is computed from the same
    exact hits of pixel rays and planes: texture coordinates, depth and flow.
    """

    def __init__(self, camera: Camera, faces: Faces, atlas: Atlas, floor_origin_m: Doubles) -> None:
        self._camera, self._faces, self._atlas = camera, faces, atlas
        self._zbuffer = ZBuffer(camera)
        self._floor_origin_m = floor_origin_m
        rays_R = camera.rays().reshape(-1, 3) @ camera.R_RC.T
        self._rays_R: Floats = rays_R.T.astype(np.float32)
        self._ray_squared: Floats = np.square(self._rays_R).sum(axis=0, dtype=np.float32)
        self._per_m: Floats = np.reciprocal(atlas.texel_m)
        self._first_cell = (faces.texture.astype(np.intp) + 1) * atlas.levels
        self._origin_px = atlas.origin_px.view(np.complex64).reshape(-1)
        cx, cy = camera.center_px
        self._x: Floats = ((np.arange(camera.cols) - cx) / camera.focal_px).astype(np.float32)
        self._y: Floats = ((np.arange(camera.rows) - cy) / camera.focal_px).astype(np.float32)[:, None]
        self._from_center_x = np.arange(camera.cols, dtype=np.float32) - np.float32(cx)
        self._from_center_y = (np.arange(camera.rows, dtype=np.float32) - np.float32(cy))[:, None]
        self._prepare_floor()

    def render(
        self,
        now: Placed,
        before: Placed | None,
        *,
        meanwhile: Sequence[Placed] = (),
        light: float = 1.0,
        noise_sigma_gray: float = 0.0,
        rng: np.random.Generator | None = None,
    ) -> Frame:
        """Return the frame seen from ``now``, with the flow since ``before``.

        ``meanwhile``: other camera poses while the shutter was open; the picture is the mean of all, the rest is of
        ``now`` alone. ``rng`` draws the image noise.
        """
        shape = self._camera.rows, self._camera.cols
        view = self._view(now)
        gray = view.gray
        for moment in meanwhile:
            gray += self._view(moment).gray
        gray *= np.float32(light / (1 + len(meanwhile)))
        if noise_sigma_gray and rng is not None:
            gray += normal_noise(gray.shape, noise_sigma_gray, rng)
        flow = None if before is None else self._flow(now, before, view)
        return Frame(
            pixels=cv2.convertScaleAbs(np.maximum(gray, 0, out=gray)).reshape(shape),
            face=view.face.reshape(shape),
            depth_m=view.depth.reshape(shape),
            obstacle=(view.face != FLOOR).view(np.uint8).reshape(shape),
            flow_px=flow,
        )

    def _view(self, placed: Placed) -> _View:
        seen = self._zbuffer.render(placed.quads_C, placed.normal_C, placed.distance_m)
        bodies = np.flatnonzero(seen.prim != FLOOR)
        face = np.full(len(seen.prim), FLOOR, np.int32)
        face[bodies] = self._faces.face_of_prim.take(seen.prim[bodies])
        with np.errstate(divide="ignore"):
            depth = np.reciprocal(seen.inverse_depth)
        return _View(seen, face, bodies, depth, self._shaded(placed, face, depth, bodies))

    def _prepare_floor(self) -> None:
        """Compute the constants of the floor's pixels: position in R, mip level and blend."""
        inverse = self._zbuffer.floor_inverse_depth
        self._sky = inverse <= 0
        self._horizon = bool(self._sky.any())
        depth = np.reciprocal(np.maximum(inverse, np.float32(1e-3)))
        place_R = (self._rays_R[:2] * depth).T
        self._floor_R: Floats = np.ascontiguousarray(place_R).reshape(self._camera.rows, self._camera.cols, 2)
        self._floor_reach_m = float(np.linalg.norm(place_R, axis=1).max())
        level, self._floor_blend = self._mip(depth, np.float32(self._camera.height_m), self._ray_squared)
        self._floor_per_m: Floats = np.repeat(self._per_m[level], 2).reshape(self._floor_R.shape)
        fine, coarse = (self._atlas.origin_px[0, one].reshape(self._floor_R.shape) for one in (level, level + 1))
        self._floor_fine_px: Floats = fine
        self._floor_coarse_px: Floats = coarse - fine * np.float32(0.5)

    def _mip(
        self, depth: Floats, distance: Floats | np.float32, ray_squared: Floats
    ) -> tuple[npt.NDArray[np.intp], Floats]:
        """Return the finer of two mip levels and the share of the coarser one, for planes at this distance.

        A pixel prints depth / f wide on a surface, and depth**2 |ray|**2 / (f distance) long.
        """
        wide = depth / np.float32(self._camera.focal_px * self._atlas.texel_m[0])
        long = wide * depth * ray_squared / distance / np.float32(STRETCH)
        level = np.log2(np.maximum(wide, long, out=long), out=long)
        np.clip(level, np.float32(0), np.float32(self._atlas.levels - 1.001), out=level)
        fine = level.astype(np.intp)
        level -= fine
        return fine, level

    def _shaded(self, now: Placed, face: Ints, depth: Floats, bodies: npt.NDArray[np.intp]) -> Floats:
        """Return the gray values before noise, float32 (rows, cols)."""
        shape = self._camera.rows, self._camera.cols
        (fine_px, coarse_px), blend = self._floor_places(now), self._floor_blend
        if len(bodies):
            blend = blend.copy()
            of_bodies = self._body_places(now, face[bodies].astype(np.intp), depth[bodies], bodies)
            blend[bodies] = of_bodies[2]
            for full, part in zip((fine_px, coarse_px), of_bodies, strict=False):
                full.view(np.complex64).reshape(-1)[bodies] = part.view(np.complex64).reshape(-1)
        fine = cv2.remap(self._atlas.pixels, fine_px, None, cv2.INTER_LINEAR)
        coarse = cv2.remap(self._atlas.pixels, coarse_px, None, cv2.INTER_LINEAR)
        gray: Floats = cv2.subtract(coarse, fine, dtype=cv2.CV_32F)
        gray *= blend.reshape(shape)
        gray += fine
        flat = gray.reshape(-1)
        if len(bodies):
            flat[bodies] = flat[bodies] * self._faces.shade.take(face[bodies])
        if self._horizon:
            flat[self._sky & (face == FLOOR)] = 255
        return gray

    def _floor_places(self, now: Placed) -> tuple[Floats, Floats]:
        """Return the atlas position of every pixel's floor point, (rows, cols, 2), on the finer and coarser level."""
        c, s = now.heading
        period = self._atlas.period_m[0]
        x, y = (now.eye_W[:2] - self._floor_origin_m) % period
        place: Floats = cv2.transform(self._floor_R, np.array([[c, -s, x], [s, c, y]]))
        reach = self._floor_reach_m
        if min(x, y) < reach or x + reach > period[0] or y + reach > period[1]:
            _wrap(place[..., 0], period[0])
            _wrap(place[..., 1], period[1])
        place *= self._floor_per_m
        place += self._floor_fine_px
        coarse = place * np.float32(0.5)
        coarse += self._floor_coarse_px
        return place, coarse

    def _body_places(
        self, now: Placed, face: npt.NDArray[np.intp], depth: Floats, at: npt.NDArray[np.intp]
    ) -> tuple[Floats, Floats, Floats]:
        """Return where on the atlas the bodies' pixels lie, (pixels, 2) on both levels, and the coarser one's share."""
        level, blend = self._mip(depth, now.face_distance_m.take(face), self._ray_squared.take(at))
        along = self._rays_R.take(at, axis=1)
        along *= depth
        per_m = self._per_m.take(level)
        place = np.empty((len(at), 2), np.float32)
        for axis, (x, y, z, one) in enumerate((now.u_R, now.v_R)):
            coordinate = x.take(face) * along[0]
            coordinate += y.take(face) * along[1]
            coordinate += z.take(face) * along[2]
            coordinate += one.take(face)
            _wrap(coordinate, self._atlas.period_m[-1, axis])
            np.multiply(coordinate, per_m, out=place[:, axis])
        cell = self._first_cell.take(face)
        cell += level
        coarse = place * np.float32(0.5)
        place += self._origin_px.take(cell).view(np.float32).reshape(-1, 2)
        coarse += self._origin_px[1:].take(cell).view(np.float32).reshape(-1, 2)
        return place, coarse, blend

    def _flow(self, now: Placed, before: Placed, view: _View) -> Floats:
        """Return the displacement of every pixel's surface point since ``before``, float32 (rows, cols, 2)."""
        rows, cols = self._camera.rows, self._camera.cols
        seen, face, bodies = view.seen, view.face, view.bodies
        inverse = seen.inverse_depth.reshape(rows, cols)
        turn, shift = before.camera_from(now)
        flow = np.empty((rows, cols, 2), np.float32)
        past = [inverse * t for t in shift]
        for axis, (x, y, one) in enumerate(turn):
            past[axis] += self._x * x
            past[axis] += self._y * y + one
        for body, moved_W in now.moved_since(before):
            at = bodies[self._faces.body[face[bodies]] == body]
            moved_C = (before.R_WC.T @ moved_W).astype(np.float32)
            for axis in range(3):
                past[axis].reshape(-1)[at] -= seen.inverse_depth[at] * moved_C[axis]
        per_depth = np.maximum(past[2], np.float32(1e-6), out=past[2])
        np.divide(np.float32(self._camera.focal_px), per_depth, out=per_depth)
        for axis, center in enumerate((self._from_center_x, self._from_center_y)):
            past[axis] *= per_depth
            np.subtract(center, past[axis], out=flow[..., axis])
        return flow


def _wrap(coordinate: Floats, period: np.float32) -> None:
    """Wrap texture coordinates to [0, period), in place."""
    coordinate -= np.floor(coordinate * (np.float32(1.0) / period)) * period
