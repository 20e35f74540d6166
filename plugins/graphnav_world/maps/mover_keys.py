"""Declared keys of a map: how obstacles move."""

from __future__ import annotations

from typing import ClassVar

from graphnav import Range, Record, key
from graphnav_world.maps.shape_keys import MAX_M, Point

MAX_S = 1000.0
MAX_MPS = 100.0


class Moves(Record):
    """How an obstacle moves: along points at constant speed, without turning.

    That a path leads to the goal is checked without the obstacles that move.
    """

    noun = "a movement"
    example = """
    circle: {center_m: [1, 2], radius_m: 0.2}
    moves: {through_m: [[2, 2], [2, 3]], speed_mps: [0.1, 0.3], around: true}
    """

    through_m: tuple[Point, ...] = key(
        min_items=1, ge=-MAX_M, le=MAX_M, doc="the points that its centre moves to, from its own centre"
    )
    speed_mps: Range[float] = key(ge=0.0, le=MAX_MPS, doc="along the way")
    around: bool = key(default=False, doc="whether it goes from the last point on to the first; else back as it came")
    ahead_m: Range[float] = key(Range(0.0, 0.0), ge=0.0, le=MAX_M, doc="how far along the way it begins")


class Crosses(Record):
    """How someone crosses the robot's way: waits, sets out when the robot comes, walks through points once.

    Speed is constant; it does not turn, and does not avoid the robot. It sets out for one of two reasons: the robot's
    centre is near (`within_m`), or it will soon be on the line that the walk follows (`within_s`). At the end of the
    walk it stands. Where it is depends on the drive; the same drive gives the same walk. That a path leads to the goal
    is checked without the obstacles that move.
    """

    noun = "a crossing"
    one_of: ClassVar[tuple[str, ...]] = ("within_m", "within_s")
    example = """
    circle: {center_m: [3, -1.5], radius_m: 0.2}
    crosses: {through_m: [[3, 1.5]], speed_mps: [0.1, 0.5], within_s: [1, 4], returns: true}
    """

    through_m: tuple[Point, ...] = key(
        min_items=1, ge=-MAX_M, le=MAX_M, doc="the points that its centre walks to, from its own centre, where it waits"
    )
    speed_mps: Range[float] = key(gt=0.0, le=MAX_MPS, doc="along the way")
    within_m: Range[float] | None = key(
        None,
        gt=0.0,
        le=MAX_M,
        doc="it sets out when the robot's centre is this near to the point where it waits",
        hint="write within_m: [1, 2] or within_s: [1, 4]",
    )
    within_s: Range[float] | None = key(
        None,
        gt=0.0,
        le=MAX_S,
        doc="it sets out when the robot's centre, at its present velocity, will be on the line of the walk within this",
    )
    returns: bool = key(default=False, doc="whether it walks back as it came, at once; else it stays at the last point")
