"""Visibility: the face seen by every pixel, from exact spans of convex quads, resolved by depth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graphnav.arrays import Doubles, Floats, Indices
from graphnav_world.rendering.camera import Camera
from graphnav_world.rendering.placed_faces import Placed

LEVEL_RATIO, TINY = 1e-9, 1e-30
"""An edge nearer than this to a picture row's direction is taken to bound the row far left, inside or out."""
FEW_PRIMS = 32
"""Of so few, all rows are looked at: finding out which may show them would cost more."""
NEAR_M, MARGIN_PX = 1e-6, 1e-3
"""A prim in front of the camera is looked for between its topmost and lowest corner, with a margin for rounding."""


@dataclass(frozen=True)
class Visible:
    """The pixels that show bodies, in runs of one row and one prim.

    ``face``: of each prim in view, (prims,); ``per_ray``: float64 (3, prims), its inverse depth (1/m, along the optical
    axis) as a linear function of a pixel's ray in C. ``prim`` (one of these) and ``row``, (runs,). ``run``, ``pixel``
    (flat index from the first of the rows that were looked for), ``x`` (columns right of the principal point) and
    ``inverse_depth``, (pixels,).
    """

    face: Indices
    per_ray: Doubles
    prim: Indices
    row: Indices
    run: Indices
    pixel: Indices
    x: Floats
    inverse_depth: Floats

    @property
    def pixel_face(self) -> Indices:
        """The face of every pixel, (pixels,)."""
        return self.face.take(self.prim).take(self.run)


_SIDES = np.array([1.0, -1.0]).reshape(2, 1, 1)
_NO_INDICES, _NO_FLOATS = np.zeros(0, np.intp), np.zeros(0, np.float32)
_NOTHING = Visible(
    face=_NO_INDICES,
    per_ray=np.zeros((3, 0)),
    prim=_NO_INDICES,
    row=_NO_INDICES,
    run=_NO_INDICES,
    pixel=_NO_INDICES,
    x=_NO_FLOATS,
    inverse_depth=_NO_FLOATS,
)


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
        self._cx, self._cy, self._focal = cx, cy, camera.focal_px
        self._row_shift = np.array([[-cy], [cy]]) + MARGIN_PX
        self._no_bound = np.array([[0, 0], [0, 1 - camera.cols]]).reshape(2, 2, 1, 1)
        self._rim = np.array([[0], [1 - camera.cols]], np.float32)
        self._nearest_fragment = np.zeros(camera.rows * camera.cols, np.int64)
        half_x, half_y = (cx + 0.5) / camera.focal_px, (cy + 0.5) / camera.focal_px
        sides = np.array([[1, 0, half_x], [-1, 0, half_x], [0, 1, half_y], [0, -1, half_y]])
        self._frustum: Doubles = sides / np.linalg.norm(sides, axis=1, keepdims=True)
        self._rows = range(camera.rows)

    def find(self, placed: Placed, rows: range | None = None) -> Visible:
        """Return what is seen of the bodies in some rows of the picture, or in all."""
        rows = rows or self._rows
        faces = placed.faces
        distance = placed.face_distance_m
        is_near = placed.heights(self._frustum_of(rows)).min(axis=0) >= -faces.prims.radius_m
        is_near &= (distance > 1e-9).take(faces.face_of_prim)
        prims = np.flatnonzero(is_near)
        if not len(prims):
            return _NOTHING
        face = faces.face_of_prim.take(prims).astype(np.intp)
        per_ray = placed.R_WC.T @ faces.normal.take(face, axis=0).T
        per_ray /= -distance.take(face)
        prim, row, first, count = self._spans(placed, prims, rows)
        run = np.repeat(np.arange(len(count)), count)
        column = np.arange(len(run))
        column += (first - np.cumsum(count) + count).take(run)
        pixel = ((row - rows.start) * self._camera.cols).take(run)
        pixel += column
        x = column.astype(np.float32)
        per_x, per_y, one = per_ray.astype(np.float32).take(prim, axis=1)
        per_x /= np.float32(self._focal)
        at_zero = per_y * self._y.take(row) + one - per_x * np.float32(self._cx)
        inverse = per_x.take(run)
        inverse *= x
        inverse += at_zero.take(run)
        x -= np.float32(self._cx)
        return self._nearest(Visible(face, per_ray, prim, row, run, pixel, x, inverse))

    def _frustum_of(self, rows: range) -> Doubles:
        if rows == self._rows:
            return self._frustum
        top, below = ((row - 0.5 - self._cy) / self._focal for row in (rows.start, rows.stop))
        sides = np.array([[0, 1, -top], [0, -1, below]])
        return np.concatenate([self._frustum[:2], sides / np.linalg.norm(sides, axis=1, keepdims=True)])

    def _nearest(self, drawn: Visible) -> Visible:
        """Return the pixels of which no other one lies in front."""
        parts = np.empty((len(drawn.pixel), 2), np.int32)
        parts[:, 0] = drawn.run
        parts[:, 0] += 1
        parts[:, 1] = drawn.inverse_depth.view(np.int32)
        fragment = parts.view(np.int64)[:, 0]
        np.maximum.at(self._nearest_fragment, drawn.pixel, fragment)
        seen = np.flatnonzero(self._nearest_fragment.take(drawn.pixel) == fragment)
        self._nearest_fragment[drawn.pixel] = 0
        if len(seen) == len(fragment):
            return drawn
        of_runs = drawn.face, drawn.per_ray, drawn.prim, drawn.row
        run, pixel = drawn.run.take(seen), drawn.pixel.take(seen)
        return Visible(*of_runs, run, pixel, drawn.x.take(seen), drawn.inverse_depth.take(seen))

    def _spans(self, placed: Placed, prims: Indices, rows: range) -> tuple[Indices, Indices, Indices, Indices]:
        """Return prim, row, first column and number of pixels of every span, each (spans,)."""
        slope, offset = self._bounds(placed.edge_planes(prims))
        all_rows = len(prims) <= FEW_PRIMS
        if all_rows:
            bound = slope[..., None] * self._y[rows.start : rows.stop]
            bound += offset[..., None]
        else:
            prim, row = self._pairs(placed.vertices(prims), rows)
            bound = slope.take(prim, axis=1)
            bound *= self._y.take(row)
            bound += offset.take(prim, axis=1)
        bound = bound.reshape(2, 4, -1).max(axis=1)
        np.maximum(bound, self._rim, out=bound)  # a prim that passes beside the eye has all its edges on one side
        first, minus_last = np.ceil(bound)
        span = np.flatnonzero(first + minus_last <= 0)
        first = first.take(span)
        count = (1 - minus_last.take(span) - first).astype(np.intp)
        if all_rows:
            prim = span // len(rows)
            row = span - prim * len(rows) + rows.start
        else:
            prim, row = prim.take(span), row.take(span)
        return prim, row, first.astype(np.intp), count

    def _pairs(self, vertices: Doubles, rows: range) -> tuple[Indices, Indices]:
        """Return every pair of a prim and a row that may show it: prim, row, each (pairs,).

        ``vertices``: corners in C, (3, 4, prims).
        """
        _, y, z = vertices
        down = y / np.maximum(z, NEAR_M)
        down *= self._focal
        minus_first, last = (np.concatenate([-down, down]).reshape(2, 4, -1).max(axis=1) + self._row_shift) // 1
        reaches_behind = z.min(axis=0) <= NEAR_M
        minus_first[reaches_behind], last[reaches_behind] = 0, np.inf
        first = -np.minimum(minus_first, -rows.start)
        count = np.maximum(np.minimum(last, rows.stop - 1) - first + 1, 0).astype(np.intp)
        prim = np.repeat(np.arange(len(count)), count)
        row = np.arange(len(prim))
        row += (first - np.cumsum(count) + count).astype(np.intp).take(prim)
        return prim, row

    def _bounds(self, planes: Doubles) -> tuple[Floats, Floats]:
        """Return the bounds that edges set to each row, as slope * y + offset: slope, offset, each (8, prims).

        The first four bound the first column from below, the others minus the last column. ``planes``: (a, b, c) of
        each edge, (3, 4, prims). The plane through the eye and an edge is a x + b y + c = 0 in the picture, positive
        inside, so that it bounds x from the left (a > 0) or from the right.
        """
        size = np.abs(planes)
        level = size[1] + size[2]
        level *= LEVEL_RATIO
        level += TINY
        a = np.where(size[0] <= level, level, planes[0])
        line = -self._focal / a * planes[1:]
        line[1] += self._cx
        is_left = a > 0
        bounds = np.where([is_left, ~is_left], line[:, None] * _SIDES, self._no_bound).astype(np.float32)
        slope, offset = bounds.reshape(2, 8, -1)
        return slope, offset
