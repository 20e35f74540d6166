"""Upper bound of steering: follow a way planned on the true map."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import ClassVar

import numpy as np

from graphnav import Latest, Map, Stage, State, Steering, param
from graphnav.arrays import Doubles
from graphnav_steer.headings import headed
from graphnav_steer.way import Way

NEXT_LAP_M = 2.0
"""Cost of what is left of a lap at which the next one is planned."""
BEHIND_M = 0.8
"""How far behind the robot's centre the corridor is cut off."""
_DEPTHS = ((0.0, 0.1), (0.1, 0.7))
"""Where the wall and the goal begin and end, in metres further behind."""


class Oracle(Stage):
    """Oracle: follows a path planned on the true map, by pure pursuit [PP].

    The path is the cheapest one to the goal region on the map inflated by the robot's radius; being near a wall costs
    more. It is known from every point, so that a robot that strays need not plan again. The robot heads for the point
    ``look_ahead_m`` along the path; with `control.nonholonomic` (T = T_m cos θ, R = R_m sin θ) that is nearly the arc
    of [PP]. Moving obstacles are ignored.

    On a map without a goal it goes round, lap by lap: the corridor that it is in is cut off behind the robot, and the
    way leads to the far side of the cut.

    References
    ----------
    .. [PP] R. C. Coulter, Implementation of the Pure Pursuit Path Tracking Algorithm, CMU-RI-TR-92-01, 1992.
    """

    role: ClassVar = "oracle"

    look_ahead_m: float = param(
        0.5, gt=0.0, le=100_000.0, doc="distance of the point to head for; more cuts corners and oscillates less"
    )
    comfort_m: float = param(
        0.25, gt=0.0, le=100_000.0, doc="clearance from the rim above which nearness costs nothing"
    )
    wall_cost: float = param(
        4.0,
        ge=0.0,
        le=1e6,
        doc="dimensionless: cost of a metre in contact with a wall, in addition to 1; more takes longer ways around",
        renamed_from="dread",
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Forget the way."""
        self._way: Way | None = None

    def step(self, state: State, map: Latest[Map]) -> Steering:  # noqa: A002  # the port's name
        """Return no repulsive force and a guiding force along the way.

        Raises
        ------
        ValueError
            The map is missing, or has neither a goal nor a corridor to go around.
        """
        if self._way is None:
            if map.value is None:
                raise ValueError("steer.oracle plans on the map: connect it: --set steer.in.map=robot.map")
            self._world = map.value.surroundings()
            self._way = self._plan(state)
        elif not len(self._world.goal_m) and self._way.cost(state.x_m, state.y_m) < NEXT_LAP_M:
            self._way = self._plan(state)
        x, y = self._way.ahead(state.x_m, state.y_m, self.look_ahead_m) - (state.x_m, state.y_m)
        theta_rad = 0.0 if x == y == 0.0 else math.remainder(math.atan2(y, x) - state.yaw_rad, 2 * math.pi)
        return headed(theta_rad)

    def _plan(self, state: State) -> Way:
        world = self._world if len(self._world.goal_m) else once_around(self._world, state)
        return Way(world, self.comfort_m, self.wall_cost)


def once_around(world: Map, state: State) -> Map:
    """Return a map that has no goal with a wall across the corridor behind the robot, and a goal behind that wall.

    The corridor is between what stands; moving obstacles do not end it.

    Raises
    ------
    ValueError
        One of the two sides has no wall: the map is not a corridor to go around.
    """
    ahead = np.array([math.cos(state.yaw_rad), math.sin(state.yaw_rad)])
    left = np.array([-ahead[1], ahead[0]])
    behind = np.array([state.x_m, state.y_m]) - BEHIND_M * ahead
    left_m, right_m = _free_m(world, behind, left), _free_m(world, behind, -left)
    if not math.isfinite(left_m + right_m):
        raise ValueError("the map has no goal to plan a way to, and no corridor to go around: use a map with a goal")
    rim = np.array([behind - right_m * left, behind + left_m * left])
    cut, goal = (np.concatenate([rim - near * ahead, rim[::-1] - far * ahead]) for near, far in _DEPTHS)
    return replace(
        world,
        kind=np.append(world.kind, np.uint8(Map.WALL)),
        height_m=np.append(world.height_m, 1.0),
        vertices_m=np.concatenate([world.vertices_m, cut]),
        body=np.append(world.body, np.full(len(cut), len(world.kind))).astype(np.int32),
        goal_m=goal,
    )


def _free_m(world: Map, here: Doubles, along: Doubles) -> float:
    """Return the distance to the nearest outline of what stands in a direction, infinite if there is none."""
    stands = world.kind[world.body] != Map.MOVING
    begin, end = world.vertices_m[stands], world.vertices_m[world.next_vertices()[stands]]
    side, across = end - begin, np.array([-along[1], along[0]])
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (here - begin) @ across / (side @ across)
        distance_m = (begin + share[:, None] * side - here) @ along
    hit = (share >= 0) & (share <= 1) & (distance_m > 0)
    return float(distance_m[hit].min(initial=math.inf))
