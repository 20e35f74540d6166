"""The picture and the exact truth of a camera over a floor with upright bodies."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from graphnav_world.atlas import LEVELS, Atlas
from graphnav_world.camera import Camera
from graphnav_world.noise import normal_noise
from graphnav_world.placed import Placed
from graphnav_world.scene import Faces
from graphnav_world.visibility import FLOOR, Visible, ZBuffer

Bytes = npt.NDArray[np.uint8]
Floats = npt.NDArray[np.float32]
Doubles = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int32]

STRETCH = 2.0
"""How much longer than wide a pixel's print on a surface may be before the texture is blurred along with it."""


@dataclass(frozen=True)
class Frame:
    """A picture and what is known of it.

    ``pixels``: uint8 (rows, cols), gray. ``face``: int32 (rows, cols), -1 for the floor and above the horizon.
    ``depth_m``: float32 (rows, cols), along the optical axis, infinite above the horizon. ``obstacle``: uint8 (rows,
    cols), 0 on the floor, 1 elsewhere. ``flow_px``: float32 (rows, cols, 2), right and down, or None for a first
    frame.
    """

    pixels: Bytes
    face: Ints
    depth_m: Floats
    obstacle: Bytes
    flow_px: Floats | None


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
        self._first_cell = (faces.texture.astype(np.intp) + 1) * LEVELS
        self._origins = [np.ascontiguousarray(atlas.origin_px[..., axis]).reshape(-1) for axis in range(2)]
        cx, cy = camera.center_px
        self._x: Floats = ((np.arange(camera.cols) - cx) / camera.focal_px).astype(np.float32)
        self._y: Floats = ((np.arange(camera.rows) - cy) / camera.focal_px).astype(np.float32)[:, None]
        self._columns: Floats = np.arange(camera.cols, dtype=np.float32)
        self._lines: Floats = np.arange(camera.rows, dtype=np.float32)[:, None]
        self._prepare_floor()

    def render(
        self,
        now: Placed,
        before: Placed | None,
        *,
        light: float = 1.0,
        noise_sigma: float = 0.0,
        rng: np.random.Generator | None = None,
    ) -> Frame:
        """Return the frame seen from ``now``, with the flow since ``before``; ``rng`` draws the image noise."""
        shape = self._camera.rows, self._camera.cols
        seen = self._zbuffer.render(now.quads_C, now.normal_C, now.distance_m)
        bodies = np.flatnonzero(seen.prim != FLOOR)
        face = np.full(len(seen.prim), FLOOR, np.int32)
        face[bodies] = self._faces.face_of_prim.take(seen.prim[bodies])
        with np.errstate(divide="ignore"):
            depth = np.reciprocal(seen.inverse_depth)
        gray = self._shaded(now, face, depth, bodies)
        gray *= np.float32(light)
        if noise_sigma and rng is not None:
            gray += normal_noise(gray.shape, noise_sigma, rng)
        obstacle = (face != FLOOR) | (seen.inverse_depth <= 0)
        flow = None if before is None else self._flow(now, before, seen, face, bodies)
        return Frame(
            pixels=cv2.convertScaleAbs(np.maximum(gray, 0, out=gray)).reshape(shape),
            face=face.reshape(shape),
            depth_m=depth.reshape(shape),
            obstacle=obstacle.view(np.uint8).reshape(shape),
            flow_px=flow,
        )

    def _prepare_floor(self) -> None:
        """Compute what the floor's pixels keep while the robot moves: their place in R, mip level and blend."""
        inverse = self._zbuffer.floor_inverse_depth
        self._sky = inverse <= 0
        self._horizon = bool(self._sky.any())
        depth = np.reciprocal(np.maximum(inverse, np.float32(1e-3)))
        self._floor_R: Floats = self._rays_R[:2] * depth
        level, self._floor_blend = self._mip(depth, np.float32(self._camera.height_m), self._ray_squared)
        fine, coarse = self._atlas.origin_px[0, level], self._atlas.origin_px[0, level + 1]
        self._floor_origins = (fine[:, 0].copy(), fine[:, 1].copy(), coarse[:, 0].copy(), coarse[:, 1].copy())
        self._floor_per_m: Floats = self._per_m[level]

    def _mip(
        self, depth: Floats, distance: Floats | np.float32, ray_squared: Floats
    ) -> tuple[npt.NDArray[np.intp], Floats]:
        """Return the finer of two mip levels and the share of the coarser one, for planes at this distance.

        A pixel prints depth / f wide on a surface, and depth**2 |ray|**2 / (f distance) long.
        """
        wide = depth / np.float32(self._camera.focal_px * self._atlas.texel_m[0])
        long = wide * depth * ray_squared / distance / np.float32(STRETCH)
        level = np.log2(np.maximum(wide, long, out=long), out=long)
        np.clip(level, np.float32(0), np.float32(LEVELS - 1.001), out=level)
        fine = level.astype(np.intp)
        level -= fine
        return fine, level

    def _shaded(self, now: Placed, face: Ints, depth: Floats, bodies: npt.NDArray[np.intp]) -> Floats:
        """Return the gray values before noise, float32 (rows, cols)."""
        shape = self._camera.rows, self._camera.cols
        maps, blend = self._floor_maps(now), self._floor_blend
        if len(bodies):
            blend = blend.copy()
            of_bodies, blend[bodies] = self._body_maps(now, face[bodies].astype(np.intp), depth[bodies], bodies)
            for one, of_body in zip(maps, of_bodies, strict=True):
                one[bodies] = of_body
        x0, y0, x1, y1 = maps.reshape(4, *shape)
        fine = cv2.remap(self._atlas.pixels, x0, y0, cv2.INTER_LINEAR)
        coarse = cv2.remap(self._atlas.pixels, x1, y1, cv2.INTER_LINEAR)
        gray: Floats = cv2.subtract(coarse, fine, dtype=cv2.CV_32F)
        gray *= blend.reshape(shape)
        gray += fine
        flat = gray.reshape(-1)
        if len(bodies):
            flat[bodies] = flat[bodies] * self._faces.shade.take(face[bodies])
        if self._horizon:
            flat[self._sky & (face == FLOOR)] = 255
        return gray

    def _floor_maps(self, now: Placed) -> Floats:
        """Return where on the atlas every pixel's floor point lies, (4, pixels): x, y on the finer level, x, y."""
        (c, s), (x, y) = now.heading, self._floor_R
        maps = np.empty((4, len(x)), np.float32)
        turned = (c, -s), (s, c)
        for axis, (along_x, along_y) in enumerate(turned):
            period = self._atlas.period_m[0, axis]
            place = x * np.float32(along_x)
            place += y * np.float32(along_y)
            place += np.float32((now.eye_W[axis] - self._floor_origin_m[axis]) % period)
            _wrap(place, period)
            place *= self._floor_per_m
            np.add(place, self._floor_origins[axis], out=maps[axis])
            place *= np.float32(0.5)
            np.add(place, self._floor_origins[axis + 2], out=maps[axis + 2])
        return maps

    def _body_maps(
        self, now: Placed, face: npt.NDArray[np.intp], depth: Floats, at: npt.NDArray[np.intp]
    ) -> tuple[Floats, Floats]:
        """Return where on the atlas the bodies' pixels lie, (4, pixels), and their blend of the two levels."""
        atlas = self._atlas
        level, blend = self._mip(depth, now.face_distance_m.take(face), self._ray_squared.take(at))
        along = self._rays_R.take(at, axis=1)
        along *= depth
        cell = self._first_cell.take(face)
        cell += level
        per_m = self._per_m.take(level)
        maps = np.empty((4, len(at)), np.float32)
        for axis, (x, y, z, one) in enumerate((now.u_R, now.v_R)):
            place = x.take(face) * along[0]
            place += y.take(face) * along[1]
            place += z.take(face) * along[2]
            place += one.take(face)
            _wrap(place, atlas.period_m[-1, axis])
            place *= per_m
            origin = self._origins[axis]
            np.add(place, origin.take(cell), out=maps[axis])
            place *= np.float32(0.5)
            np.add(place, origin[1:].take(cell), out=maps[axis + 2])
        return maps, blend

    def _flow(self, now: Placed, before: Placed, seen: Visible, face: Ints, bodies: npt.NDArray[np.intp]) -> Floats:
        """Return the displacement of every pixel's surface point since ``before``, float32 (rows, cols, 2)."""
        rows, cols = self._camera.rows, self._camera.cols
        inverse = seen.inverse_depth.reshape(rows, cols)
        turn, shift = before.camera_from(now)
        flow = np.empty((rows, cols, 2), np.float32)
        past = [(self._x * q[0] + (self._y * q[1] + q[2])) + inverse * t for q, t in zip(turn, shift, strict=True)]
        for body, moved_W in now.moved_since(before):
            at = bodies[self._faces.body[face[bodies]] == body]
            moved_C = (before.R_WC.T @ moved_W).astype(np.float32)
            for axis in range(3):
                past[axis].reshape(-1)[at] -= seen.inverse_depth[at] * moved_C[axis]
        per_depth = np.float32(self._camera.focal_px) / np.maximum(past[2], np.float32(1e-6))
        cx, cy = (np.float32(c) for c in self._camera.center_px)
        np.subtract(self._columns - cx, past[0] * per_depth, out=flow[..., 0])
        np.subtract(self._lines - cy, past[1] * per_depth, out=flow[..., 1])
        return flow


def _wrap(coordinate: Floats, period: np.float32) -> None:
    """Bring texture coordinates into [0, period), in place."""
    coordinate -= np.floor(coordinate * (np.float32(1.0) / period)) * period
