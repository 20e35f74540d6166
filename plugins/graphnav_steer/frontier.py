"""Steering along the cheapest path to the frontier of what is known."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from graphnav import Goal, Latest, LocalMap, Stage, Steering, param
from graphnav.arrays import Bools, Doubles, Indices
from graphnav_steer.axes import toward
from graphnav_steer.local_paths import Paths, beside, cheapest_paths

Point = tuple[float, float]

_TRAIL_STEP_M = 0.1
_MAX_TRAIL = 400
_SAME_M = 0.3
"""Frontiers nearer to the last choice than this are the same choice."""


class Way(NamedTuple):
    """A path (n, 2) of rows and columns to a frontier, its cost with what comes after, its end, and the open cells."""

    cost_m: float
    end_m: Point
    path: Indices
    passable: Bools


class Frontier(Stage):
    """Drives to a frontier: the edge of what is known, where the way may go on.

    The map is taken optimistically: the robot may pass wherever nothing that it has seen is nearer than its radius and
    a margin. The cells of that space which the robot knows to be free are planned through; where they end and unknown
    floor begins is a frontier [Y]. The robot takes the cheapest one: the path there, which costs more near obstacles,
    and from there the way to the goal. Without a goal the turn that it takes, and returning to where the robot has
    been, cost instead. It keeps to its choice until another one is cheaper by ``commit_m``.

    The steering points to the farthest point of the path that the robot can drive to straight on. Where there is neither
    a frontier nor the goal, the robot turns on the spot.

    References
    ----------
    .. [Y] B. Yamauchi, A Frontier-Based Approach for Autonomous Exploration, CIRA 1997.
    """

    robot_radius_m: float = param(0.2, gt=0.0, le=10.0, doc="radius of the robot's body")
    margin_m: float = param(0.05, ge=0.0, doc="distance to keep from obstacles beyond the radius")
    narrow_cost_m: float = param(1.5, ge=0.0, doc="cost of a way that cannot keep `margin_m`")
    comfort_m: float = param(0.25, gt=0.0, doc="distance from obstacles beyond the radius from which nearness costs nothing")
    near_cost: float = param(
        6.0, ge=0.0, doc="dimensionless: cost of a metre along an obstacle, in addition to 1; more keeps to the middle"
    )
    look_ahead_m: float = param(0.6, gt=0.0, doc="distance of the farthest point of the path to head for")
    turn_cost_m: float = param(0.6, ge=0.0, doc="cost of a first turn by half a circle where there is no goal")
    back_cost_m: float = param(3.0, ge=0.0, doc="cost of a frontier where the robot has been, where there is no goal")
    commit_m: float = param(0.4, ge=0.0, doc="by how much another frontier must be cheaper to be preferred")
    goal_weight: float = param(1.0, ge=0.0, doc="dimensionless: cost of a metre between a frontier and the goal")

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Forget where the robot has been."""
        self._trail: list[Point] = []
        self._chosen: Point | None = None
        self._spin = 1.0

    def step(self, map: LocalMap, goal: Latest[Goal]) -> Steering:  # noqa: A002  # the port's name
        """Return the steering along the path: no repulsive force, a guiding force of length 1."""
        self._remember(map)
        theta_rad = self._theta_rad(map, goal.value)
        along, nothing = toward(theta_rad), np.zeros(2)
        return Steering(repulsive=nothing, guiding=along, control=along, theta_rad=theta_rad, eigenvalues=nothing)

    def _remember(self, map: LocalMap) -> None:  # noqa: A002
        here = (map.x_m, map.y_m)
        if not self._trail or math.dist(self._trail[-1], here) > _TRAIL_STEP_M:
            self._trail = [*self._trail[1 - _MAX_TRAIL :], here]

    def _theta_rad(self, map: LocalMap, goal: Goal | None) -> float:  # noqa: A002
        ways = [self._way(map, goal, margin_m) for margin_m in (self.margin_m, 0.0)]
        costs_m = [math.inf if way is None else way.cost_m for way in ways]
        way = ways[0] if costs_m[0] <= costs_m[1] + self.narrow_cost_m else ways[1]
        if way is None:
            self._chosen = None
            return self._spin * math.pi / 2
        self._chosen = way.end_m
        theta_rad = self._toward(map, way.path, way.passable)
        if theta_rad:
            self._spin = math.copysign(1.0, theta_rad)
        return theta_rad

    def _way(self, map: LocalMap, goal: Goal | None, margin_m: float) -> Way | None:  # noqa: A002
        """Return the cheapest way that keeps a distance from obstacles beyond the radius, None if there is none."""
        (row,), (col,) = map.cells_at(np.zeros(1), np.zeros(1))
        kept_m = min(self.robot_radius_m + margin_m, float(map.obstacle_m[row, col]))
        open_cells = map.obstacle_m >= kept_m
        known = open_cells & (map.unknown_m >= min(self.robot_radius_m, float(map.unknown_m[row, col])))
        frontier = open_cells & ~known & beside(known)
        passable = known | frontier
        paths = self._paths((int(row), int(col)), map, passable)
        rows, cols = np.nonzero(frontier & np.isfinite(paths.cost_m))
        if not len(rows):
            return None
        x_m, y_m = map.origin_x_m + cols * map.cell_m, map.origin_y_m + rows * map.cell_m
        cost_m = paths.cost_m[rows, cols] + self._cost_beyond_m(map, goal, x_m, y_m)
        best = self._best(x_m, y_m, cost_m)
        path = paths.to(int(rows[best]), int(cols[best]))
        return Way(float(cost_m[best]), (float(x_m[best]), float(y_m[best])), path, passable)

    def _paths(self, start: tuple[int, int], map: LocalMap, passable: Bools) -> Paths:  # noqa: A002
        near = np.clip(1.0 - (map.obstacle_m - self.robot_radius_m) / self.comfort_m, 0.0, 1.0)
        price = np.where(passable, 1.0 + self.near_cost * near**2, math.inf)
        return cheapest_paths(start, price, map.cell_m, limit_m=50.0)

    def _cost_beyond_m(self, map: LocalMap, goal: Goal | None, x_m: Doubles, y_m: Doubles) -> Doubles:  # noqa: A002
        """Return the cost of what comes after points on the map: the way to the goal, or a return."""
        if goal is None:
            return self._cost_of_return_m(map, x_m, y_m)
        bearing_rad = map.yaw_rad + goal.bearing_rad
        goal_x_m = map.x_m + goal.distance_m * math.cos(bearing_rad)
        goal_y_m = map.y_m + goal.distance_m * math.sin(bearing_rad)
        return np.asarray(self.goal_weight * np.hypot(x_m - goal_x_m, y_m - goal_y_m))

    def _best(self, x_m: Doubles, y_m: Doubles, cost_m: Doubles) -> int:
        """Return which point is cheapest; the last choice has `commit_m` less."""
        if self._chosen is not None:
            apart_m = np.hypot(x_m - self._chosen[0], y_m - self._chosen[1])
            cost_m = cost_m - self.commit_m * (apart_m < _SAME_M)
        return int(np.argmin(cost_m))

    def _cost_of_return_m(self, map: LocalMap, x_m: Doubles, y_m: Doubles) -> Doubles:  # noqa: A002
        turn = np.arctan2(y_m - map.y_m, x_m - map.x_m) - map.yaw_rad
        cost_m = self.turn_cost_m * np.abs(np.remainder(turn + math.pi, 2 * math.pi) - math.pi) / math.pi
        trail = np.array(self._trail[:-4] or self._trail[:1])
        apart_m = np.hypot(x_m[:, None] - trail[:, 0], y_m[:, None] - trail[:, 1]).min(axis=1)
        return np.asarray(cost_m + self.back_cost_m * np.clip(1.0 - apart_m / 1.0, 0.0, 1.0))

    def _toward(self, map: LocalMap, path: Indices, passable: Bools) -> float:  # noqa: A002  # the port's name
        """Return the angle from forward to the farthest point of the path to which a straight way leads."""
        x_m, y_m = map.origin_x_m + path[:, 1] * map.cell_m, map.origin_y_m + path[:, 0] * map.cell_m
        away_m = np.hypot(x_m - map.x_m, y_m - map.y_m)
        last = min(2, len(path) - 1)
        for k in range(last, len(path)):
            if away_m[k] > self.look_ahead_m:
                break
            share = np.linspace(0.0, 1.0, max(2, math.ceil(away_m[k] / map.cell_m * 2)))
            cells = map.cells_of(map.x_m + share * (x_m[k] - map.x_m), map.y_m + share * (y_m[k] - map.y_m))
            if not passable[cells][1:].all():
                break
            last = k
        return math.remainder(math.atan2(y_m[last] - map.y_m, x_m[last] - map.x_m) - map.yaw_rad, 2 * math.pi)
