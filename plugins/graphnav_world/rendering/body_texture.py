"""The bodies in the picture: their textures at the pixels where they are seen."""

from __future__ import annotations

import cv2
import numpy as np

from graphnav.arrays import Floats, Indices
from graphnav_world.geometry.scene import Faces
from graphnav_world.rendering.atlas import Atlas
from graphnav_world.rendering.camera import Camera
from graphnav_world.rendering.mip import mip_levels
from graphnav_world.rendering.placed_faces import Placed
from graphnav_world.rendering.visibility import Visible

BLOCK = 256
"""Columns of the picture into which all pixels of bodies are gathered for the lookup: OpenCV limits its sides."""


class BodyTexture:
    """Draws what is seen of bodies.

    Texture coordinates are affine functions of the surface point, so that times inverse depth they are affine in the
    picture: each run of pixels has two numbers for each.
    """

    def __init__(self, camera: Camera, faces: Faces, atlas: Atlas) -> None:
        self._camera, self._faces, self._atlas = camera, faces, atlas
        cy = camera.center_px[1]
        self._y: Floats = ((np.arange(camera.rows) - cy) / camera.focal_px).astype(np.float32)
        self._texture_axes = np.stack([faces.u, faces.v], axis=1) / atlas.period_m[-1][:, None]
        self._first_cell = (faces.texture.astype(np.intp) + 1) * atlas.levels
        self._origin_px = atlas.origin_px.view(np.complex64).reshape(-1)
        width, height = (atlas.period_m[-1] / atlas.texel_m[0]).tolist()
        self._width_px: Floats = np.float32(width) * np.float32(0.5) ** np.arange(atlas.levels, dtype=np.float32)
        self._height_ratio = np.float32(height / width)

    def gray(self, now: Placed, seen: Visible) -> Floats:
        """Return the gray values of the seen pixels before light and noise, float32 (pixels,)."""
        numbers, first_cell, shade = self._runs(now, seen)
        u, u_slope, v, v_slope, ratio, ratio_slope = numbers.take(seen.run, axis=1)
        depth = np.reciprocal(seen.inverse_depth)
        _set_to_fraction(u, u_slope, seen.x, depth)
        _set_to_fraction(v, v_slope, seen.x, depth)
        ratio_slope *= seen.x
        ratio_slope *= seen.x
        ratio += ratio_slope
        ratio *= depth
        level, blend = mip_levels(depth, ratio, self._camera, self._atlas.levels)
        fine, coarse = self._lookup(u, v, self._width_px.take(level), first_cell.take(seen.run) + level)
        gray: Floats = cv2.subtract(coarse[None], fine[None], dtype=cv2.CV_32F)[0]
        gray *= blend
        gray += fine
        gray *= shade.take(seen.run)
        return gray

    def _runs(self, now: Placed, seen: Visible) -> tuple[Floats, Indices, Floats]:
        """Return the constants of each run of pixels: numbers, float32 (6, runs), first cell and shade, each (runs,).

        The numbers are both texture coordinates over their periods, times inverse depth, at the middle column, each
        with its slope; and length over width of a pixel's print, over depth, there, with the factor of the squared
        column.
        """
        face = seen.face
        slope, offset = now.affine(self._texture_axes, face)
        slope += (offset - np.floor(offset))[..., None] * seen.per_ray[:, None]
        prims = np.empty((7, len(face)), np.float32)
        prims[:6] = slope.reshape(-1, 6).T
        np.divide(1, now.face_distance_m.take(face), out=prims[6])
        u_x, u_y, u, v_x, v_y, v, ratio = prims.take(seen.prim, axis=1)
        y, per_focal = self._y.take(seen.row), np.float32(1 / self._camera.focal_px)
        numbers = np.empty((6, len(y)), np.float32)
        np.add(u_y * y, u, out=numbers[0])
        np.multiply(u_x, per_focal, out=numbers[1])
        np.add(v_y * y, v, out=numbers[2])
        np.multiply(v_x, per_focal, out=numbers[3])
        np.multiply(y * y + 1, ratio, out=numbers[4])
        np.multiply(ratio, per_focal * per_focal, out=numbers[5])
        return numbers, self._first_cell.take(face).take(seen.prim), self._faces.shade.take(face).take(seen.prim)

    def _lookup(self, u: Floats, v: Floats, width_px: Floats, cell: Indices) -> tuple[Floats, Floats]:
        """Return the texels, uint8 (pixels,), of the finer and the coarser level.

        ``u``, ``v``: position in the texture, from 0 to 1. ``cell``: index of texture and finer level.
        """
        n = len(cell)
        place = np.zeros((2, -(-n // BLOCK) * BLOCK, 2), np.float32)
        np.multiply(u, width_px, out=place[0, :n, 0])
        np.multiply(v, width_px * self._height_ratio, out=place[0, :n, 1])
        np.multiply(place[0], np.float32(0.5), out=place[1])
        at = place.view(np.complex64)[..., 0]
        at[0, :n] += self._origin_px.take(cell)
        at[1, :n] += self._origin_px[1:].take(cell)
        texels = cv2.remap(self._atlas.pixels, place.reshape(-1, BLOCK, 2), None, cv2.INTER_LINEAR).reshape(2, -1)
        return texels[0, :n], texels[1, :n]


def _set_to_fraction(coordinate: Floats, slope: Floats, x: Floats, depth: Floats) -> None:
    """Replace coordinates in the middle column, over depth, by the fraction of those at x; writes to ``slope``."""
    slope *= x
    coordinate += slope
    coordinate *= depth
    coordinate -= np.floor(coordinate, out=slope)
