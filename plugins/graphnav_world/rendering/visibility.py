"""Visibility: the face seen by every pixel, from exact spans of convex quads, resolved by depth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graphnav.arrays import Doubles, Floats, Ints, Longs
from graphnav_world.rendering.camera import Camera

FLOOR = -1
LEVEL_RATIO, TINY = 1e-9, 1e-30
"""An edge nearer than this to a picture row's direction is taken to bound the row far left, inside or out."""


@dataclass(frozen=True)
class Visible:
    """The faces seen by the pixels, flat, row by row.

    ``prim``: int32 (pixels,), -1 for the floor (and above the horizon). ``inverse_depth``: float32 (pixels,), 1/m
    along the optical axis, 0 above the horizon.
    """

    prim: Ints
    inverse_depth: Floats


class ZBuffer:
    """Finds the nearest face of every pixel.

    A pixel belongs to a convex polygon where its ray is on the inner side of all planes through the eye and an
    edge; in one image row that is a span, so that all spans of all polygons come from a few array operations.
    This needs no clipping at a near plane (M. Olano, T. Greer, Triangle scan conversion using 2D homogeneous
    coordinates, 1997). Inverse depth is affine in the picture, so each span's depths are two numbers. Among
    faces at the same depth the last one wins.
    """

    def __init__(self, camera: Camera) -> None:
        self._camera = camera
        cx, cy = camera.center_px
        self._y = ((np.arange(camera.rows) - cy) / camera.focal_px).astype(np.float32)
        self._cx, self._focal = cx, camera.focal_px
        half = np.array([cx + 0.5, cy + 0.5]) / camera.focal_px
        self._frustum = np.array([[1, 0, half[0]], [-1, 0, half[0]], [0, 1, half[1]], [0, -1, half[1]], [0, 0, 1.0]])
        down = camera.R_RC[2]
        floor = -(camera.rays() @ down) / camera.height_m
        self.floor_inverse_depth: Floats = np.maximum(floor, 0.0).astype(np.float32).reshape(-1)

    def render(self, quads_C: Doubles, normal_C: Doubles, distance_m: Doubles) -> Visible:
        """Return the visible quads of every pixel, given quads in C, float64 (prims, 4, 3).

        ``normal_C``: outward normals (prims, 3). ``distance_m``: of the eye before the planes; only prims with a
        positive one face the camera.
        """
        camera = self._camera
        shown = np.flatnonzero(distance_m > 1e-9)
        beyond = (quads_C[shown].reshape(-1, 3) @ self._frustum.T < 0).reshape(-1, 4, 5).all(axis=1).any(axis=1)
        shown = shown[~beyond]
        key = np.zeros(camera.rows * camera.cols, np.int64)
        if len(shown):
            self._paint(key, shown.astype(np.int32), quads_C[shown], normal_C[shown] / -distance_m[shown, None])
        halves = key.view(np.int32).reshape(-1, 2)
        prim = halves[:, 0] - np.int32(1)
        inverse_depth = np.where(prim < 0, self.floor_inverse_depth, halves[:, 1].view(np.float32))
        return Visible(prim, inverse_depth)

    def _paint(self, key: Longs, prims: Ints, quads: Doubles, per_ray: Doubles) -> None:
        """Raise ``key`` (inverse depth's bits above, prim + 1 below) to the nearest of these prims."""
        first, last = self._spans(quads)
        prim, row = np.nonzero(last >= first)
        start = first[prim, row]
        count = last[prim, row] - start + np.int32(1)
        ends = np.cumsum(count, dtype=np.int32)
        if not len(ends):
            return
        pixel_x = np.arange(ends[-1], dtype=np.int32)
        pixel_x += np.repeat(start - ends + count, count)
        x, y, one = per_ray.astype(np.float32).T
        slope = (x / np.float32(self._focal)).take(prim)
        at_zero = y.take(prim) * self._y.take(row) + one.take(prim) - slope * np.float32(self._cx)
        depth = np.repeat(slope, count)
        depth *= pixel_x
        depth += np.repeat(at_zero, count)
        fragment = np.empty((ends[-1], 2), np.int32)
        fragment[:, 0] = np.repeat((prims + np.int32(1)).take(prim), count)
        fragment[:, 1] = depth.view(np.int32)
        pixel = np.repeat(row * self._camera.cols, count)
        pixel += pixel_x
        np.maximum.at(key, pixel, fragment.view(np.int64).reshape(-1))

    def _spans(self, quads: Doubles) -> tuple[Ints, Ints]:
        """Return the first and last column of every prim in every row, int32 (prims, rows).

        The plane through the eye and an edge is a x + b y + c = 0 in the picture, positive inside, so that in each
        row it bounds x from the left (a > 0) or from the right.
        """
        x0, y0, z0 = quads.transpose(2, 1, 0)
        x1, y1, z1 = quads.take([1, 2, 3, 0], axis=1).transpose(2, 1, 0)
        a, b, c = y1 * z0 - z1 * y0, z1 * x0 - x1 * z0, x1 * y0 - y1 * x0
        level = np.abs(a) <= LEVEL_RATIO * (np.abs(b) + np.abs(c))
        a[level] = LEVEL_RATIO * (np.abs(b) + np.abs(c))[level] + TINY
        scale = -self._focal / a
        slope, offset = scale * b, scale * c + self._cx
        offset[level & (b == 0) & (c == 0)] = -1.0
        left = a > 0
        first = self._bound(np.where(left, slope, 0.0), np.where(left, offset, -1.0)).max(axis=0)
        right = self._camera.cols
        last = self._bound(np.where(left, 0.0, slope), np.where(left, right, offset)).min(axis=0)
        np.ceil(np.clip(first, 0, right, out=first), out=first)
        np.floor(np.clip(last, -1, right - 1, out=last), out=last)
        return first.astype(np.int32), last.astype(np.int32)

    def _bound(self, slope: Doubles, offset: Doubles) -> Floats:
        """Return slope * y + offset for every row, float32 (edges, prims, rows)."""
        bound: Floats = slope.astype(np.float32)[..., None] * self._y
        bound += offset.astype(np.float32)[..., None]
        return bound
