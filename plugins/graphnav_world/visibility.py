"""Which face every pixel sees: exact spans of convex quads, resolved by depth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from graphnav_world.camera import Camera

Doubles = npt.NDArray[np.float64]
Floats = npt.NDArray[np.float32]
Ints = npt.NDArray[np.int32]

FLOOR = -1
TINY_SLOPE, ON_EDGE = np.float32(1e-37), np.float32(1e-30)
"""An edge along a row bounds it at minus or plus infinity; a row exactly on it, and a repeated vertex, are inside."""


@dataclass(frozen=True)
class Visible:
    """What the pixels see, flat, row by row.

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
        """Return what every pixel sees of quads in C, float64 (prims, 4, 3).

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

    def _paint(self, key: npt.NDArray[np.int64], prims: Ints, quads: Doubles, per_ray: Doubles) -> None:
        """Raise ``key`` (inverse depth's bits above, prim + 1 below) to the nearest of these prims."""
        first, last = self._spans(quads)
        prim, row = np.nonzero(last >= first)
        start = first[prim, row]
        count = last[prim, row] - start + np.int32(1)
        ends = np.cumsum(count)
        if not len(ends):
            return
        pixel_x = np.repeat(start - (ends - count).astype(np.int32), count)
        pixel_x += np.arange(ends[-1], dtype=np.int32)
        coefficients = per_ray.astype(np.float32)
        slope = coefficients[prim, 0] / np.float32(self._focal)
        at_zero = coefficients[prim, 1] * self._y[row] + coefficients[prim, 2] - slope * np.float32(self._cx)
        fragment = np.empty((ends[-1], 2), np.int32)
        fragment[:, 0] = np.repeat(prims[prim] + np.int32(1), count)
        depth = np.repeat(slope, count)
        depth *= pixel_x
        depth += np.repeat(at_zero, count)
        fragment[:, 1] = depth.view(np.int32)
        pixel = np.repeat(row * np.intp(self._camera.cols), count)
        pixel += pixel_x
        np.maximum.at(key, pixel, fragment.view(np.int64).reshape(-1))

    def _spans(self, quads: Doubles) -> tuple[Ints, Ints]:
        """Return the first and last column of every prim in every row, int32 (prims, rows)."""
        x, y, z = quads.transpose(2, 0, 1)
        x1, y1, z1 = quads.take([1, 2, 3, 0], axis=1).transpose(2, 0, 1)
        edges = y1 * z - z1 * y, z1 * x - x1 * z, x1 * y - y1 * x
        a, b, c = (edge.astype(np.float32)[..., None] for edge in edges)
        a[a == 0] = TINY_SLOPE
        inside = b * self._y + c
        inside += ON_EDGE
        with np.errstate(over="ignore"):
            crossing = np.divide(inside, a / np.float32(-self._focal), out=inside)
        crossing += np.float32(self._cx)
        bounds_left = a > 0
        first = np.where(bounds_left, crossing, np.float32(-np.inf)).max(axis=1)
        last = np.where(bounds_left, np.float32(np.inf), crossing).min(axis=1)
        np.ceil(np.clip(first, 0, self._camera.cols, out=first), out=first)
        np.floor(np.clip(last, -1, self._camera.cols - 1, out=last), out=last)
        return first.astype(np.int32), last.astype(np.int32)
