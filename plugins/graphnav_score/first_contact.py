"""The first contact of a drive: with what, and who ran into whom."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from graphnav import Map, Metric, State
from graphnav.arrays import Doubles

CONTACT_METRICS = (
    Metric(
        "hit_mover",
        better="lower",
        min_difference=0.05,
        help="1 if what it touched first moves, else 0; left out where the map has nothing that moves.",
        bounds=(0.0, 1.0),
    ),
    Metric(
        "hit_by_mover",
        better="lower",
        min_difference=0.05,
        help="1 if what it touched first moves and brought the larger share of the speed at which the two closed, "
        "along the line of contact, else 0; left out where the map has nothing that moves.",
        bounds=(0.0, 1.0),
    ),
    Metric(
        "at_fault",
        better="lower",
        min_difference=0.05,
        help="1 if what it touched first moves and the robot itself drove towards it at more than 0.05 m/s, along the "
        "line of contact, else 0: a robot that stands, or drives away, is not at fault; left out where the map has "
        "nothing that moves.",
        bounds=(0.0, 1.0),
    ),
    Metric(
        "drove_into",
        better="lower",
        min_difference=0.05,
        help="1 if the robot was at fault and what moves brought no more than 0.05 m/s, along the line of contact: it "
        "would not have touched a robot that stood; else 0. Of the contacts with what moves, those at fault and not of "
        "this kind are by both, and those not at fault are those in which the robot was run into. Left out where the "
        "map has nothing that moves.",
        bounds=(0.0, 1.0),
    ),
    Metric(
        "own_share",
        better="lower",
        min_difference=0.05,
        help="Share of the speed at which the two closed, along the line of contact, that was the robot's own: 1 if it "
        "drove into what stood or went away, 0 if it stood or drove away; left out without a contact with what moves.",
        bounds=(0.0, 1.0),
    ),
)
AT_FAULT_MPS = 0.05
"""A robot that drives towards a mover faster than this when they touch could have stopped; a mover that comes no faster
would not have touched it if it had."""


class FirstContact:
    """Judges the first state with a contact, against the state before it.

    What was touched is the body nearest to the robot's centre there. A mover goes on between the contact and the stamp
    of that state: of its way since the state before, the place nearest to the robot counts. The speeds that close are
    along the line from the mover's nearest point to the robot's centre: the robot's as in the state before, because
    the contact ends its motion, the mover's as the mean since then. So a robot that brakes counts as fast as it was
    up to one state earlier.
    """

    def __init__(self) -> None:
        self._before: tuple[State, float] | None = None
        self._has_touched = self._hit_mover = False
        self._robot_mps = self._mover_mps = 0.0

    def add(self, state: State, world: Map | None, time_s: float) -> None:
        """Look at the next state."""
        if state.contact and not self._has_touched and world is not None and _agree(world, state):
            self._judge(state, world.surroundings(), time_s)
        self._has_touched |= state.contact
        self._before = state, time_s

    def metrics(self, world: Map | None) -> Mapping[str, float]:
        """Return the metrics of the drive so far, none where nothing moves."""
        if world is None or Map.MOVING not in world.kind:
            return {}
        robot_mps, mover_mps = self._robot_mps, self._mover_mps
        at_fault = robot_mps > AT_FAULT_MPS
        values = {
            "hit_mover": float(self._hit_mover),
            "hit_by_mover": float(mover_mps > robot_mps),
            "at_fault": float(at_fault),
            "drove_into": float(at_fault and mover_mps <= AT_FAULT_MPS),
        }
        closing_mps = max(robot_mps, 0.0) + max(mover_mps, 0.0)
        return {**values, "own_share": max(robot_mps, 0.0) / closing_mps} if closing_mps else values

    def _judge(self, state: State, world: Map, time_s: float) -> None:
        before, before_s = self._before or (state, time_s)
        body, to_robot_m = _touched(world, state, before)
        if world.kind[body] != Map.MOVING:
            return
        self._hit_mover = True
        distance_m, interval_s = math.hypot(*to_robot_m), time_s - before_s
        if not distance_m or not interval_s:
            return
        mover = int((world.kind[:body] == Map.MOVING).sum())
        towards = to_robot_m / distance_m
        self._mover_mps = float((state.moving[mover, :2] - before.moving[mover, :2]) @ towards / interval_s)
        heading = np.array([math.cos(before.yaw_rad), math.sin(before.yaw_rad)])
        self._robot_mps = float(-before.v_mps * heading @ towards)


def _agree(world: Map, state: State) -> bool:
    """Return whether a map has bodies, and as many that move as a state has poses of."""
    return len(world.kind) > 0 and int((world.kind == Map.MOVING).sum()) == len(state.moving)


def _touched(world: Map, state: State, before: State) -> tuple[int, Doubles]:
    """Return the body nearest to the robot's centre, and the way from its nearest point to there, (x, y) in W."""
    robot_m = np.array([state.x_m, state.y_m])
    ways: list[Doubles] = []
    movers = iter(zip(before.moving[:, :2], state.moving[:, :2], strict=True))
    for body, kind in enumerate(world.kind):
        outline = world.vertices_m[world.body == body]
        places = [np.zeros(2)]
        if kind == Map.MOVING:
            then, now = next(movers)
            places = [then + share * (now - then) for share in np.linspace(0.0, 1.0, 11)]
        found = [_way_from(outline + place, robot_m) for place in places]
        ways.append(min(found, key=_length_m))
    nearest = int(np.argmin([_length_m(way) for way in ways]))
    return nearest, ways[nearest]


def _way_from(outline: Doubles, point: Doubles) -> Doubles:
    """Return the shortest way from an outline to a point, (x, y)."""
    along = np.roll(outline, -1, axis=0) - outline
    length2 = np.maximum((along**2).sum(axis=1), 1e-18)
    share = np.clip(((point - outline) * along).sum(axis=1) / length2, 0.0, 1.0)
    ways: Doubles = point - (outline + share[:, None] * along)
    shortest: Doubles = ways[int(np.argmin((ways**2).sum(axis=1)))]
    return shortest


def _length_m(way: Doubles) -> float:
    return math.hypot(*way)
