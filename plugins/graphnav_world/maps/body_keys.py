"""Declared keys of a map: walls, obstacles, pillars, corridors."""

from __future__ import annotations

from typing import Literal

from graphnav import Range, Record, key
from graphnav_world.maps.mover_keys import Crosses, Moves
from graphnav_world.maps.shape_keys import MAX_DEG, MAX_M, Bend, Point, Shaped, Size

MAX_PILLARS = 1000
_TEXTURE = "its texture: one of `textures`, or floor, wall or obstacle"


class Wall(Record):
    """A wall along a line of points and arcs, half of its thickness on either side.

    Two points are a straight wall, three a corner; a closed wall is a room.
    """

    noun = "a wall"
    example = """
    walls:
      - along: [[0, 0], [2, 0], {arc: {center_m: [2, 1], radius_m: 1, from_deg: -90, to_deg: 0}}, [3, 2]]
        height_m: 0.35
        texture: brick
      - {along: [[0, 0], [4, 0], [4, 3], [0, 3]], closed: true}    # a room
    """

    along: tuple[Point | Bend, ...] = key(ge=-MAX_M, le=MAX_M, doc="its middle line: points [x, y] and arcs, in order")
    height_m: Range[float] = key(Range(0.35, 0.35), gt=0.0, le=MAX_M, doc="above the floor")
    thickness_m: Range[float] = key(Range(0.1, 0.1), gt=0.0, le=MAX_M, doc="across the line")
    closed: bool = key(default=False, doc="whether it returns from the last point to the first")
    texture: str = key("wall", doc=_TEXTURE)


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


class CorridorKeys(Record):
    """A corridor with one bend, closed at both ends: it brings its walls, the start, and a goal across its far end.

    It begins at the origin and leads along x; the robot starts there.
    """

    noun = "a corridor"
    example = """
    corridor: {turn: left, radius_m: [2.5, 5], half_width_m: 0.7, bend_deg: [90, 180], run_in_m: 1.5, run_out_m: 0.5,
               start_offset_m: [-0.1, 0.1], start_heading_deg: 0}
    """

    turn: Literal["left", "right"] = key(doc="the side to which it bends: left is counterclockwise")
    radius_m: Range[float] = key(gt=0.0, le=MAX_M, doc="of the bend's middle line")
    half_width_m: Range[float] = key(gt=0.0, le=MAX_M, doc="from the middle line to either wall")
    bend_deg: Range[float] = key(gt=0.0, le=MAX_DEG, doc="how far it bends")
    run_in_m: Range[float] = key(gt=0.0, le=MAX_M, doc="the straight part before the bend")
    run_out_m: Range[float] = key(
        gt=0.0, le=MAX_M, doc="the straight part between the bend and the goal, which is 0.5 m deep"
    )
    start_offset_m: Range[float] = key(ge=-MAX_M, le=MAX_M, doc="of the robot from the middle line, to the left")
    start_heading_deg: Range[float] = key(ge=-MAX_DEG, le=MAX_DEG, doc="of the robot, from x counterclockwise")
    height_m: Range[float] = key(Range(0.35, 0.35), gt=0.0, le=MAX_M, doc="of the walls above the floor")
    thickness_m: Range[float] = key(Range(0.1, 0.1), gt=0.0, le=MAX_M, doc="of the walls")
    texture: str = key("wall", doc="of the walls: one of `textures`, or floor, wall or obstacle")
