"""Outlines of shapes on the floor as polygons, and their convex parts.

Outlines are float64 (n, 2) in metres, counterclockwise, without repeating the first vertex.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from graphnav.arrays import Bools, Doubles

CIRCLE_SIDES = 16
SHARPEST_MITRE = 4.0
"""Maximum extent of a wall's corner, in half thicknesses."""


def circle(x_m: float, y_m: float, radius_m: float, sides: int = CIRCLE_SIDES) -> Doubles:
    """Return a regular polygon with its corners on the circle."""
    angles = (np.arange(sides) + 0.5) * (2 * math.pi / sides)
    return np.stack([x_m + radius_m * np.cos(angles), y_m + radius_m * np.sin(angles)], axis=1)


def box(x_m: float, y_m: float, length_m: float, width_m: float, turn_rad: float) -> Doubles:
    """Return a rectangle around a centre; ``length_m`` lies along ``turn_rad``."""
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.array([length_m, width_m]) / 2
    c, s = math.cos(turn_rad), math.sin(turn_rad)
    turned: Doubles = corners @ np.array([[c, s], [-s, c]]) + np.array([x_m, y_m])
    return turned


def arc(center_m: Sequence[float], radius_m: float, from_rad: float, to_rad: float) -> Doubles:
    """Return points on an arc, ends included; a chord leaves the arc by at most 2 mm."""
    angles = np.linspace(from_rad, to_rad, arc_points(radius_m, from_rad, to_rad))
    return np.asarray(center_m) + radius_m * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def arc_points(radius_m: float, from_rad: float, to_rad: float) -> int:
    """Return how many points `arc` has."""
    step = 2 * math.acos(max(1 - 0.002 / radius_m, 0.5))
    return max(2, math.ceil(abs(to_rad - from_rad) / step) + 1)


def signed_area(outline: Doubles) -> float:
    """Return the area of a polygon, positive if it runs counterclockwise."""
    x, y = outline[:, 0], outline[:, 1]
    return float(0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def counterclockwise(outline: Doubles) -> Doubles:
    """Return the outline running counterclockwise."""
    return outline if signed_area(outline) >= 0 else outline[::-1].copy()


def crosses_itself(outline: Doubles) -> bool:
    """Whether two non-adjacent sides of a closed outline touch."""
    n, ends = len(outline), np.roll(outline, -1, axis=0)
    others = (slice(i + 2, n - 1 if i == 0 else n) for i in range(n - 2))  # the first and the last side are adjacent
    return any(_touched(outline[i], ends[i], outline[other], ends[other]).any() for i, other in enumerate(others))


def contains(outline: Doubles, x_m: float, y_m: float) -> bool:
    """Whether a point lies inside an outline (even-odd rule)."""
    a, b = outline, np.roll(outline, -1, axis=0)
    above = (a[:, 1] > y_m) != (b[:, 1] > y_m)
    rise = np.where(above, b[:, 1] - a[:, 1], 1.0)
    at = a[:, 0] + (y_m - a[:, 1]) * (b[:, 0] - a[:, 0]) / rise
    return bool(np.count_nonzero(above & (x_m < at)) % 2)


def distance(outline: Doubles, x_m: float, y_m: float) -> float:
    """Return the distance of a point from an outline's area, zero inside."""
    if contains(outline, x_m, y_m):
        return 0.0
    a, b = outline, np.roll(outline, -1, axis=0)
    p, along = np.array([x_m, y_m]), b - a
    share = np.clip(((p - a) * along).sum(1) / np.maximum((along * along).sum(1), 1e-12), 0, 1)
    return float(np.min(np.linalg.norm(a + share[:, None] * along - p, axis=1)))


def convex_parts(outline: Doubles) -> list[Doubles]:
    """Return convex polygons that tile a simple counterclockwise outline (triangles if it is not convex)."""
    if _min_turn(outline) >= 0:
        return [outline]
    left = list(range(len(outline)))
    parts = []
    while len(left) > 3:
        ear = next((i for i in range(len(left)) if _is_ear(outline, left, i)), 0)
        parts.append(outline[[left[ear - 1], left[ear], left[(ear + 1) % len(left)]]])
        del left[ear]
    return [*parts, outline[left]]


@dataclass(frozen=True)
class Strip:
    """A wall from above: the two rims of a thick polyline, vertex by vertex, both (n, 2)."""

    left: Doubles
    right: Doubles
    closed: bool

    @property
    def pieces(self) -> list[Doubles]:
        """The convex quads between consecutive vertices, (4, 2): right, right next, left next, left."""
        n = len(self.left)
        ends = [(i, (i + 1) % n) for i in range(n if self.closed else n - 1)]
        return [np.array([self.right[i], self.right[j], self.left[j], self.left[i]]) for i, j in ends]

    @property
    def is_folded(self) -> bool:
        """Whether the line bends within less than the thickness, so that the inner rim runs backwards."""
        return any(_min_turn(piece) < -1e-12 for piece in self.pieces)

    @property
    def outline(self) -> Doubles:
        """One outline; that of a closed strip has a seam of no width."""
        if not self.closed:
            return np.concatenate([self.right, self.left[::-1]])
        left, right = self.left[::-1], self.right
        return np.concatenate([right, right[:1], left[-1:], left])


def strip(points_m: Doubles, thickness_m: float, *, closed: bool) -> Strip:
    """Return the strip of a polyline with mitred corners (very sharp ones are cut)."""
    along = (np.roll(points_m, -1, axis=0) if closed else points_m[1:]) - (points_m if closed else points_m[:-1])
    along = along / np.linalg.norm(along, axis=1, keepdims=True)
    normals = np.stack([-along[:, 1], along[:, 0]], axis=1)
    before = np.roll(normals, 1, axis=0) if closed else np.concatenate([normals[:1], normals])
    after = normals if closed else np.concatenate([normals, normals[-1:]])
    mitre = before + after
    reach = 2.0 / np.maximum((mitre * mitre).sum(1, keepdims=True), 4 / SHARPEST_MITRE**2)
    offset = mitre * reach * (thickness_m / 2)
    return Strip(points_m + offset, points_m - offset, closed)


def _turn(a: Doubles, b: Doubles, c: Doubles) -> Doubles:
    """Return the turn from ``ab`` to ``ac``, positive to the left; each point is (2,), or (2, n) for several."""
    turn: Doubles = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    return turn


def _min_turn(outline: Doubles) -> float:
    """Return the minimum turn at a vertex; negative if the outline is not convex."""
    before, after = np.roll(outline, 1, axis=0), np.roll(outline, -1, axis=0)
    return float(_turn(before.T, outline.T, after.T).min())


def _touched(a: Doubles, b: Doubles, begins: Doubles, ends: Doubles) -> Bools:
    """Return which of several segments, (n, 2) each, the segment from ``a`` to ``b`` touches, (n,)."""
    c, d = begins.T, ends.T
    of_a, of_b = _turn(a, b, c), _turn(a, b, d)
    of_c, of_d = _turn(c, d, a), _turn(c, d, b)
    overlaps = np.all(np.minimum(a, b) <= np.maximum(begins, ends), axis=1)
    overlaps &= np.all(np.minimum(begins, ends) <= np.maximum(a, b), axis=1)
    on_one_line = (of_a == 0) & (of_b == 0) & (of_c == 0) & (of_d == 0)
    found: Bools = np.where(on_one_line, overlaps, (of_a * of_b <= 0) & (of_c * of_d <= 0))
    return found


def _is_ear(outline: Doubles, left: list[int], i: int) -> bool:
    a, b, c = (outline[left[k % len(left)]] for k in (i - 1, i, i + 1))
    if _turn(a, b, c) <= 0:
        return False
    corners = {left[i - 1], left[i], left[(i + 1) % len(left)]}
    others = outline[[k for k in left if k not in corners]].T
    is_left = (_turn(a, b, others) >= 0) & (_turn(b, c, others) >= 0) & (_turn(c, a, others) >= 0)
    return not is_left.any()
