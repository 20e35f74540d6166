"""Declared keys of a map: walls, obstacles, pillars."""

from __future__ import annotations

from graphnav import Range, Record, key
from graphnav_world.maps.mover_keys import Crosses, Moves
from graphnav_world.maps.shape_keys import MAX_M, Bend, Point, Shaped, Size

MAX_PILLARS = 300
_TEXTURE = "its texture: one of `textures`, or floor, wall or obstacle"


class Door(Record):
    """An opening in a wall, from the floor up."""

    noun = "a door"
    example = """
    walls:
      - {along: [[0, 0], [4, 0]], doors: [{at_m: [1, 3], width_m: [0.5, 0.8]}]}
    """

    at_m: Range[float] = key(ge=0.0, le=MAX_M, doc="its middle, along the wall's line from its first point")
    width_m: Range[float] = key(gt=0.0, le=MAX_M, doc="along the line, from one end of the wall to the other")


class Wall(Record):
    """A wall along a line of points and arcs, half of its thickness on either side.

    Two points are a straight wall, three a corner; a closed wall is a room. Doors cut it into several walls.
    """

    noun = "a wall"
    example = """
    walls:
      - along: [[0, 0], [2, 0], {arc: {center_m: [2, 1], radius_m: 1, from_deg: -90, to_deg: 0}}, [3, 2]]
        height_m: 0.35
        texture: brick
      - {along: [[0, 0], [4, 0], [4, 3], [0, 3]], closed: true}    # a room
      - {along: [[2, 0], [2, 3]], doors: [{at_m: [0.5, 2.5], width_m: 0.7}]}    # across it, with a door
    """

    along: tuple[Point | Bend, ...] = key(ge=-MAX_M, le=MAX_M, doc="its middle line: points [x, y] and arcs, in order")
    height_m: Range[float] = key(Range(0.35, 0.35), gt=0.0, le=MAX_M, doc="above the floor")
    thickness_m: Range[float] = key(Range(0.1, 0.1), gt=0.0, le=MAX_M, doc="across the line")
    closed: bool = key(default=False, doc="whether it returns from the last point to the first")
    texture: str = key("wall", doc=_TEXTURE)
    doors: tuple[Door, ...] = key((), doc="openings in it")


class Obstacle(Shaped):
    """Stands on the floor, or moves over it: a prism on a shape."""

    noun = "an obstacle"
    example = """
    obstacles:
      - {circle: {center_m: [1, [0.4, 0.6]], radius_m: 0.2}, height_m: 0.5}
      - {box: {center_m: [3, 0], size_m: [0.4, 0.2], turn_deg: 30}, texture: brick}
      - circle: {center_m: [1, 2], radius_m: 0.2}
        moves: {through_m: [[2, 2]], speed_mps: 0.2}
      - circle: {center_m: [4, -1.5], radius_m: 0.2}
        height_m: 1.7
        crosses: {through_m: [[4, 1.5]], speed_mps: [0.1, 0.5], within_m: [1, 2]}
    """

    height_m: Range[float] = key(Range(0.5, 0.5), gt=0.0, le=MAX_M, doc="above the floor")
    texture: str = key("obstacle", doc=_TEXTURE)
    moves: Moves | None = key(None, doc="how it moves at all times; without it and `crosses`, it stands still")
    crosses: Crosses | None = key(None, doc="how it crosses the robot's way once; not together with `moves`")


class Region(Shaped):
    """A region of the floor, by one shape. A run ends when the robot's centre is in it."""

    noun = "the goal"
    example = "goal: {box: {center_m: [8, 3], size_m: [1, 6]}}"


class Field(Record):
    """A rectangle along the axes."""

    noun = "the field"

    corner_m: Point = key(ge=-MAX_M, le=MAX_M, doc="its corner of minimum x and y")
    size_m: Size = key(gt=0.0, le=MAX_M, doc="its lengths along x and y")


class Pillars(Record):
    """Round obstacles, placed at random, apart from each other."""

    noun = "a field of pillars"
    example = "pillars: {count: [20, 40], radius_m: [0.1, 0.25], gap_m: 0.8, field: {corner_m: [0, 0], size_m: [8, 6]}}"

    count: Range[int] = key(ge=1, le=MAX_PILLARS, doc="how many")
    radius_m: Range[float] = key(gt=0.0, le=MAX_M, doc="of each; a range is drawn for each")
    gap_m: Range[float] = key(ge=0.0, le=MAX_M, doc="the minimum distance between the rims of two")
    field: Field = key(doc="where they are")
    height_m: Range[float] = key(Range(0.5, 0.5), gt=0.0, le=MAX_M, doc="above the floor")
    texture: str = key("obstacle", doc=_TEXTURE)
