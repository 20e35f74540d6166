"""Declared keys of a map: shapes on the floor."""

from __future__ import annotations

from typing import ClassVar, NamedTuple

from graphnav import Range, Record, key

MAX_M = 1000.0
"""Bound of lengths and coordinates; a map is much smaller."""
MAX_DEG = 3600.0


class Point(NamedTuple):
    """A point on the floor, in metres; each coordinate may be a range."""

    x: Range[float]
    y: Range[float]


class Circle(Record):
    """A regular polygon of 16 sides whose corners are on the circle."""

    noun = "a circle"
    example = "circle: {center_m: [1, 0.5], radius_m: [0.15, 0.25]}"

    center_m: Point = key(ge=-MAX_M, le=MAX_M, doc="its centre")
    radius_m: Range[float] = key(gt=0.0, le=MAX_M, doc="from the centre to the corners")


class Size(NamedTuple):
    """Lengths along the two axes, in metres; each may be a range."""

    x: Range[float]
    y: Range[float]


class Box(Record):
    """A rectangle around its centre."""

    noun = "a box"
    example = "box: {center_m: [3, 0], size_m: [0.4, 0.2], turn_deg: 30}"

    center_m: Point = key(ge=-MAX_M, le=MAX_M, doc="its centre")
    size_m: Size = key(gt=0.0, le=MAX_M, doc="its lengths along x and y before it is turned")
    turn_deg: Range[float] = key(
        Range(0.0, 0.0), ge=-MAX_DEG, le=MAX_DEG, doc="turns it about its centre, counterclockwise"
    )


class Polygon(Record):
    """A polygon by its corners, in either direction; its sides do not cross."""

    noun = "a polygon"
    example = "polygon: {points_m: [[4, 0], [5, 0], [5, 1], [4.5, 0.5]]}"

    points_m: tuple[Point, ...] = key(min_items=3, ge=-MAX_M, le=MAX_M, doc="its corners, in order around it")


class Shaped(Record):
    """Something on the floor, by one shape."""

    one_of: ClassVar[tuple[str, ...]] = ("circle", "box", "polygon")

    circle: Circle | None = key(None, doc="it is round", hint="write circle: {center_m: [x, y], radius_m: 0.2}")
    box: Box | None = key(None, doc="it is rectangular, and may be turned")
    polygon: Polygon | None = key(None, doc="it has corners")

    @property
    def shape(self) -> Circle | Box | Polygon:
        """The one shape that it has."""
        found = self.circle or self.box or self.polygon
        assert found is not None
        return found


class ArcKeys(Record):
    """A part of a circle."""

    noun = "an arc"
    example = "arc: {center_m: [2, 1], radius_m: 1, from_deg: -90, to_deg: 0}"

    center_m: Point = key(ge=-MAX_M, le=MAX_M, doc="the centre of the circle")
    radius_m: Range[float] = key(gt=0.0, le=MAX_M, doc="of the circle")
    from_deg: Range[float] = key(
        ge=-MAX_DEG, le=MAX_DEG, doc="the direction from the centre to where it begins; 0 is along x, 90 along y"
    )
    to_deg: Range[float] = key(
        ge=-MAX_DEG, le=MAX_DEG, doc="the direction to where it ends: counterclockwise if greater than `from_deg`"
    )


class Bend(Record):
    """An item of a wall's line that is not a point."""

    noun = "an arc of a line"

    arc: ArcKeys = key(doc="the line runs along it from its beginning to its end")
