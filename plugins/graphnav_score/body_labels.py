"""Which body of the map stands at a place of the floor plan: a raster of the plan."""

from __future__ import annotations

import cv2
import numpy as np

from graphnav import Map
from graphnav.arrays import Doubles, Floats, Ints

_CELL_M = 0.02
_MAX_CELLS = 4000
_MARGIN_M = 0.05
"""Points this far beside a body count as its own: a pixel's depth is that of its middle."""


class BodyLabels:
    """The standing obstacles of a map, drawn on a grid of 2 cm (coarser where the map is larger than 80 m).

    Attributes
    ----------
    bodies
        The indices of the standing obstacles.
    """

    def __init__(self, world: Map) -> None:
        self.bodies = np.flatnonzero(world.kind == Map.OBSTACLE)
        self._labels: Ints = np.full((1, 1), -1, np.int32)
        self._origin_m: Doubles = np.zeros(2)
        self._cell_m = _CELL_M
        outlines = [world.vertices_m[world.body == body] for body in self.bodies]
        if outlines:
            self._draw(outlines)

    def at(self, points_m: Floats) -> Ints:
        """Return the body at each of ``points_m`` (n, 2) in W, its index on the map; -1 where none stands."""
        cols, rows = ((points_m - self._origin_m) / self._cell_m).astype(np.int64).T
        inside = (rows >= 0) & (cols >= 0) & (rows < self._labels.shape[0]) & (cols < self._labels.shape[1])
        found = np.full(len(points_m), -1, np.int32)
        found[inside] = self._labels[rows[inside], cols[inside]]
        return found

    def _draw(self, outlines: list[Doubles]) -> None:
        points = np.concatenate(outlines)
        span_m = np.ptp(points, axis=0) + 4 * _MARGIN_M
        self._cell_m = max(_CELL_M, float(span_m.max()) / _MAX_CELLS)
        self._origin_m = points.min(axis=0) - 2 * _MARGIN_M
        cols, rows = np.ceil(span_m / self._cell_m).astype(int)
        self._labels = np.full((rows, cols), -1, np.int32)
        thickness = 1 + 2 * round(_MARGIN_M / self._cell_m)
        drawn = [((outline - self._origin_m) / self._cell_m).astype(np.int32) for outline in outlines]
        for body, corners in zip(self.bodies.tolist(), drawn, strict=True):
            cv2.polylines(self._labels, [corners], True, body, thickness)  # noqa: FBT003  # closed
        for body, corners in zip(self.bodies.tolist(), drawn, strict=True):
            cv2.fillPoly(self._labels, [corners], body)
