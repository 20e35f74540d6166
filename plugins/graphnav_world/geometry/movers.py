"""The obstacles that move, in one drive: where each one is at any time so far."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol

from graphnav_world.geometry.crossing import Crossing, Pair
from graphnav_world.geometry.patrol import Patrol
from graphnav_world.geometry.polynomial_path import PolynomialPath

Course = Patrol | Crossing | PolynomialPath
"""How an obstacle moves, as a map says it; it is the same in all drives."""


class Mover(Protocol):
    """An obstacle that moves."""

    @property
    def speed_mps(self) -> float:
        """The maximum of its speed."""
        ...

    def at(self, time_s: float) -> Pair:
        """Return the position (x, y) in W."""
        ...


class Walker:
    """An obstacle on a crossing: it waits until it sees the robot come, so that its position depends on the drive.

    Positions are known up to the last time at which it saw the robot: later it may set out.
    """

    def __init__(self, crossing: Crossing) -> None:
        self._crossing = crossing
        self._began_s: float | None = None

    @property
    def speed_mps(self) -> float:
        """Its speed once it has set out."""
        return self._crossing.speed_mps

    def see(self, time_s: float, robot_m: Pair, velocity_mps: Pair) -> None:
        """Set out if the robot's centre here, with this velocity, is a reason to; times must not decrease."""
        if self._began_s is None and self._crossing.is_due(robot_m, velocity_mps):
            self._began_s = time_s

    def at(self, time_s: float) -> Pair:
        """Return the position (x, y) in W; it waits at all times before it set out."""
        return self._crossing.at(0.0 if self._began_s is None else time_s - self._began_s)


def movers_of(courses: Iterable[Course]) -> tuple[Mover, ...]:
    """Return the obstacles on these courses at the start of a drive, in their order."""
    return tuple(Walker(course) if isinstance(course, Crossing) else course for course in courses)
