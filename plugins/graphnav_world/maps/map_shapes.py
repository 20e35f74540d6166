"""The shapes of a map, drawn: outlines on the floor, and the lines of walls."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from graphnav.arrays import Doubles
from graphnav_world.geometry import outlines
from graphnav_world.maps.draws import Draws
from graphnav_world.maps.shape_keys import ArcKeys, Bend, Box, Circle, Point, Polygon

MAX_CORNERS = 500
"""Of a polygon, which is cut into convex parts."""


@dataclass(frozen=True)
class Shape:
    """An outline and the point that carries it when it moves."""

    outline: Doubles
    center: Doubles


def draw_shape(draws: Draws, wanted: Circle | Box | Polygon) -> Shape | None:
    """Return a shape, None if it is not one."""
    if isinstance(wanted, Circle):
        x, y = draws.pair(wanted.center_m)
        return Shape(outlines.circle(x, y, draws.number(wanted.radius_m)), np.array([x, y]))
    if isinstance(wanted, Box):
        x, y = draws.pair(wanted.center_m)
        turn_rad = math.radians(draws.number(wanted.turn_deg))
        return Shape(outlines.box(x, y, *draws.pair(wanted.size_m), turn_rad), np.array([x, y]))
    return _polygon(draws, wanted)


def draw_line(draws: Draws, items: tuple[Point | Bend, ...]) -> Doubles:
    """Return the points of a wall's line, (n, 2); repeated points count once."""
    runs = [_arc(draws, item.arc) if isinstance(item, Bend) else np.array([draws.pair(item)]) for item in items]
    points = np.concatenate([np.zeros((0, 2)), *runs])
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    is_new = np.concatenate([np.ones(min(len(points), 1), bool), steps > 1e-9])
    kept: Doubles = points[is_new]
    return kept


def _polygon(draws: Draws, wanted: Polygon) -> Shape | None:
    points = np.array([draws.pair(point) for point in wanted.points_m])
    if len(points) > 3 and np.linalg.norm(points[-1] - points[0]) < 1e-9:
        points = points[:-1]
    if len(points) > MAX_CORNERS:
        what = f"this polygon has {len(points)} corners, but may have {MAX_CORNERS}"
        draws.wrong(wanted.place("points_m"), what, "leave some out")
        return None
    if outlines.crosses_itself(points) or abs(outlines.signed_area(points)) < 1e-9:
        what, hint = "this polygon crosses itself or has no area", "list its corners in order"
        draws.wrong(wanted.place("points_m"), what, hint)
        return None
    return Shape(outlines.counterclockwise(points), points.mean(axis=0))


def _arc(draws: Draws, arc: ArcKeys) -> Doubles:
    center, radius_m = draws.pair(arc.center_m), draws.number(arc.radius_m)
    start, end = (math.radians(draws.number(angle)) for angle in (arc.from_deg, arc.to_deg))
    if not draws.may_add(outlines.arc_points(radius_m, start, end), arc.place("to_deg")):
        return np.zeros((0, 2))
    return outlines.arc(center, radius_m, start, end)
