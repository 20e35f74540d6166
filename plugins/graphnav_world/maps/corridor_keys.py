"""Declared keys of a map: corridors and worlds of BARN, which bring what surrounds the robot, and its start."""

from __future__ import annotations

from typing import Literal

from graphnav import Range, Record, key
from graphnav_world.maps.shape_keys import MAX_DEG, MAX_M

MAX_CORNERS = 20
MAX_CORNER_DEG = 135.0
N_WORLDS = 300
N_MOVING_WORLDS = 60


class Walled(Record):
    """Keys that all corridors have: walls, and the robot's start, at the origin along x."""

    half_width_m: Range[float] = key(gt=0.0, le=MAX_M, doc="from the middle line to either wall")
    start_offset_m: Range[float] = key(ge=-MAX_M, le=MAX_M, doc="of the robot from the middle line, to the left")
    start_heading_deg: Range[float] = key(ge=-MAX_DEG, le=MAX_DEG, doc="of the robot, from x counterclockwise")
    height_m: Range[float] = key(Range(0.35, 0.35), gt=0.0, le=MAX_M, doc="of the walls above the floor")
    thickness_m: Range[float] = key(Range(0.1, 0.1), gt=0.0, le=MAX_M, doc="of the walls")
    texture: str = key("wall", doc="of the walls: one of `textures`, or floor, wall or obstacle")


class CorridorKeys(Walled):
    """A corridor with one bend, closed at both ends: it brings its walls, the start, and a goal across its far end.

    It begins at the origin and leads along x; the robot starts there.
    """

    noun = "a corridor"
    example = """
    corridor: {turn: left, radius_m: [2.5, 5], half_width_m: 0.7, bend_deg: [90, 180], run_in_m: 1.5, run_out_m: 0.5,
               start_offset_m: [-0.1, 0.1], start_heading_deg: 0}
    """

    turn: Literal["left", "right", "either"] = key(
        doc="the side to which it bends: left is counterclockwise, either is drawn"
    )
    radius_m: Range[float] = key(gt=0.0, le=MAX_M, doc="of the bend's middle line")
    bend_deg: Range[float] = key(gt=0.0, le=360.0, doc="how far it bends")
    run_in_m: Range[float] = key(gt=0.0, le=MAX_M, doc="the straight part before the bend")
    run_out_m: Range[float] = key(
        gt=0.0, le=MAX_M, doc="the straight part between the bend and the goal, which is 0.5 m deep"
    )


class ZigzagKeys(Walled):
    """A corridor with sharp corners to alternate sides: one is an L, two are an S or a Z.

    It is closed at both ends, and brings its walls, the start, and a goal across its far end. It begins at the origin
    and leads along x; the robot starts there. At a T junction it also goes straight on past a corner, into a dead end.
    """

    noun = "a zigzag"
    example = """
    zigzag: {turn: either, corners: [1, 3], corner_deg: [60, 90], straight_m: [2.5, 3.5], half_width_m: 0.7,
             dead_ends: [0, 1], dead_end_m: 0.5, start_offset_m: 0, start_heading_deg: 0}
    """

    turn: Literal["left", "right", "either"] = key(doc="the side of the first corner; either is drawn")
    corners: Range[int] = key(ge=1, le=MAX_CORNERS, doc="how many")
    corner_deg: Range[float] = key(gt=0.0, le=MAX_CORNER_DEG, doc="how far each turns, drawn for each")
    straight_m: Range[float] = key(
        gt=0.0, le=MAX_M, doc="middle line from corner to corner, and from the last one to the goal; drawn for each"
    )
    run_in_m: Range[float] = key(Range(1.5, 1.5), gt=0.0, le=MAX_M, doc="middle line before the first corner")
    dead_ends: Range[int] = key(
        Range(0, 0), ge=0, le=MAX_CORNERS, doc="how many of the corners are T junctions; which ones is drawn"
    )
    dead_end_m: Range[float] = key(
        Range(0.5, 0.5), gt=0.0, le=MAX_M, doc="length of each dead end, beyond the corridor that branches off"
    )


class RingKeys(Walled):
    """A corridor around a rectangle with round corners, back into itself: it has no end and no goal.

    It passes through the origin along x, in the middle of a side; the robot starts there.
    """

    noun = "a ring"
    example = """
    ring: {turn: left, length_m: [6, 9], width_m: [5, 7], radius_m: [1.5, 2.5], half_width_m: 0.7, start_offset_m: 0,
           start_heading_deg: 0}
    """

    turn: Literal["left", "right", "either"] = key(
        doc="the side to which it bends: left is counterclockwise, either is drawn"
    )
    length_m: Range[float] = key(gt=0.0, le=MAX_M, doc="of the rectangle of its middle line, along x")
    width_m: Range[float] = key(gt=0.0, le=MAX_M, doc="of the rectangle of its middle line, across")
    radius_m: Range[float] = key(gt=0.0, le=MAX_M, doc="of its middle line in the corners")


class BarnKeys(Record):
    """One of the 300 static worlds of the BARN challenge: it brings its cylinders, the start and the goal.

    Up to 365 cylinders of 0.15 m diameter stand on a grid of 0.15 m: a field from y = 5.1 to 9.6 m, which the robot
    enters from a lane below and leaves at the top, between two rows of cylinders 4.35 m apart. It starts at (-2.25, 3)
    and looks along y; the goal is the circle of 1 m around (-2.25, 13). Beyond the field the floor is free without
    end: add a wall around the goal, as the map of the graph `barn_navigate` does.

    The worlds are those of D. Perille, A. Truong, X. Xiao and P. Stone, Benchmarking Metric Ground Navigation, SSRR
    2020; their licence is beside them.
    """

    noun = "a world of BARN"
    example = """
    barn: {}                # the world whose number the seed of the run is; from 300 on, what remains of it by 300
    barn: {world: 49}
    barn: {world: [0, 99]}  # one of these, drawn
    """

    world: Range[int] | None = key(
        None, ge=0, le=N_WORLDS - 1, doc="its number; without it the seed of the run, modulo 300"
    )
    height_m: Range[float] = key(Range(1.0, 1.0), gt=0.0, le=MAX_M, doc="of the cylinders above the floor")
    texture: str = key("obstacle", doc="of the cylinders: one of `textures`, or floor, wall or obstacle")


class BarnMovingKeys(Record):
    """One of sixty worlds of cylinders that move on polynomials: it brings them, the start and the goal, but no wall.

    The robot starts at (-2.25, 3) and looks along y; the goal is the circle of 1 m around (-2.25, 13), as in a world of
    `barn`. The cylinders have a radius of 0.25 m and stay entirely in the field between, from x = -4.5 to 0 and from
    y = 4.5 to 11.5. Each goes to and fro between two opposite sides of the field, on the graph of a polynomial through
    random points, and through other cylinders; its speed rises and falls as a sine, and near both ends it slows down
    and turns back. Where it is depends on time alone.

    Worlds 0 to 19 are easy, 20 to 39 medium, 40 to 59 hard: 3 to 6, 5 to 9 or 8 to 12 cylinders on polynomials of order
    1 to 2, 2 to 4 or 3 to 6, with a mean speed of 0.1 to 0.3, 0.3 to 0.6 or 0.6 to 1.0 m/s, and a standard deviation of
    at most 0.05, 0.15 or 0.3 m/s. All of that is the world's number; the seed of the run draws only the surfaces.

    The method is that of A. Nair, F. Jiang, K. Hou, Z. Xu, S. Li, X. Xiao and P. Stone, DynaBARN: Benchmarking Metric
    Ground Navigation in Dynamic Environments, SSRR 2022; the worlds are not theirs.
    """

    noun = "a world of moving cylinders"
    example = """
    barn_moving: {}                 # the world whose number the seed of the run is; from 60 on, the rest by 60
    barn_moving: {world: 49}
    barn_moving: {collection: 1}    # sixty other worlds, for tuning
    """

    world: Range[int] | None = key(
        None, ge=0, le=N_MOVING_WORLDS - 1, doc="its number; without it the seed of the run, modulo 60"
    )
    collection: Range[int] = key(
        Range(0, 0), ge=0, le=1_000_000, doc="which sixty worlds; results are reported on those of 0, so tune on others"
    )
    height_m: Range[float] = key(Range(1.0, 1.0), gt=0.0, le=MAX_M, doc="of the cylinders above the floor")
    texture: str = key("obstacle", doc="of the cylinders: one of `textures`, or floor, wall or obstacle")
