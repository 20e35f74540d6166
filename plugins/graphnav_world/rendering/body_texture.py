"""The bodies in the picture: their textures at the pixels where they are seen."""

from __future__ import annotations

import math

import cv2
import numpy as np

from graphnav.arrays import Floats, Indices
from graphnav_world.geometry.scene import Faces
from graphnav_world.rendering.atlas import Atlas
from graphnav_world.rendering.camera import Camera
from graphnav_world.rendering.mip import mip_levels
from graphnav_world.rendering.placed_faces import Placed
from graphnav_world.rendering.visibility import Visible

LARGEST_SIDE = 4096
"""Columns of the picture into which all pixels of bodies are gathered for the lookup: OpenCV limits its sides."""


class BodyTexture:
    """Draws what is seen of bodies.

    Texture coordinates are affine functions of the surface point, so that times inverse depth they are affine in the
    picture: each run of pixels has two numbers for each.
    """

    def __init__(self, camera: Camera, faces: Faces, atlas: Atlas) -> None:
        self._camera, self._faces, self._atlas = camera, faces, atlas
        cy = camera.center_px[1]
        y = (np.arange(camera.rows) - cy) / camera.focal_px
        self._of_row: Floats = np.stack([y, y, y**2 + 1]).astype(np.float32)
        axes = np.stack([faces.u, faces.v], axis=1) / atlas.period_m[-1][:, None]
        self._texture_axes = np.ascontiguousarray(axes.T)
        self._first_cell = (faces.texture.astype(np.intp) + 1) * atlas.levels
        self._origin_px = atlas.origin_px.view(np.complex64).reshape(-1)
        self._size_px = (atlas.period_m[-1][:, None] / atlas.texel_m).astype(np.float32)

    def gray(self, now: Placed, seen: Visible) -> Floats:
        """Return the gray values of the seen pixels before light and noise, float32 (pixels,)."""
        numbers = self._runs(now, seen).take(seen.run, axis=1)
        depth = np.reciprocal(seen.inverse_depth)
        values, slopes, shade = numbers[:3], numbers[3:6], numbers[6]
        slopes *= seen.x
        slopes[2] *= seen.x
        values += slopes
        values *= depth
        place, length_ratio = values[:2], values[2]
        place -= np.floor(place, out=slopes[:2])
        level, blend = mip_levels(depth, length_ratio, self._camera, self._atlas.levels)
        cell = self._first_cell.take(seen.pixel_face)
        cell += level
        fine, coarse = self._lookup(place, level, cell)
        gray: Floats = cv2.subtract(coarse[None], fine[None], dtype=cv2.CV_32F)[0]
        gray *= blend
        gray += fine
        gray *= shade
        return gray

    def _runs(self, now: Placed, seen: Visible) -> Floats:
        """Return the constants of each run of pixels, float32 (7, runs).

        At the middle column: both texture coordinates over their periods, times inverse depth, and length over width of
        a pixel's print, over depth. The slopes of both coordinates, and the factor of the squared column. The shade.
        """
        slope, offset = now.affine(self._texture_axes, seen.face)
        offset -= np.floor(offset)
        slope += offset * seen.per_ray[:, None]
        per_focal = 1 / self._camera.focal_px
        prims = np.empty((9, len(seen.face)), np.float32)
        prims[:2], prims[2:4] = slope[2], slope[1]
        np.multiply(slope[0], per_focal, out=prims[5:7])
        np.divide([[1.0], [per_focal**2]], now.face_distance_m.take(seen.face), out=prims[4:8:3])
        prims[8] = self._faces.shade.take(seen.face)
        runs = prims.take(seen.prim, axis=1)
        runs[2:5] *= self._of_row.take(seen.row, axis=1)
        runs[2:4] += runs[:2]
        return runs[2:]

    def _lookup(self, place: Floats, level: Indices, cell: Indices) -> tuple[Floats, Floats]:
        """Return the texels, uint8 (pixels,), of the finer and the coarser level.

        ``place``: in the texture, from 0 to 1, (2, pixels). ``cell``: index of texture and finer level.
        """
        n = len(cell)
        rows = math.ceil(n / LARGEST_SIDE)
        place_px = np.zeros((2, rows * math.ceil(n / rows), 2), np.float32)
        np.multiply(place, self._size_px.take(level, axis=1), out=place_px[0, :n].T)
        np.multiply(place_px[0], np.float32(0.5), out=place_px[1])
        at = place_px.view(np.complex64)[..., 0]
        at[0, :n] += self._origin_px.take(cell)
        at[1, :n] += self._origin_px[1:].take(cell)
        maps = place_px.reshape(2 * rows, -1, 2)
        texels = cv2.remap(self._atlas.pixels, maps, None, cv2.INTER_LINEAR).reshape(2, -1)
        return texels[0, :n], texels[1, :n]
