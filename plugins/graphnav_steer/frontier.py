"""Steering along the cheapest path to the frontier of what is known."""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np

from graphnav import Goal, Latest, LocalMap, RecoveryState, Stage, Steering, param
from graphnav.arrays import Bools, Doubles, Indices
from graphnav_steer.giving_way import out_of_the_way_rad
from graphnav_steer.headings import apart_rad, headed
from graphnav_steer.local_paths import beside, cheapest_paths

Point = tuple[float, float]

_NO_RECOVERY: Latest[RecoveryState] = Latest()
_TRAIL_STEP_M = 0.1
_FAR_M = 1e6
"""A goal that is farther away counts as this far: only its bearing matters."""
_MIN_SQUEEZE_M = 1e-6
_SAME_M = 0.3
"""Frontiers nearer to the last choice than this are the same choice."""


class Way(NamedTuple):
    """A path (n, 2) of rows and columns to a frontier, and its end in the frame of the map."""

    end_m: Point
    path: Indices


class Frontier(Stage):
    """Drives to a frontier: the edge of what is known, where the way may go on.

    The map is taken optimistically: the robot may pass wherever nothing that it has seen is nearer than its radius and
    a margin. The cells of that space which the robot knows to be free are planned through; where they end and unknown
    floor begins is a frontier [Y]. The robot takes the cheapest one: the path there, which costs more near obstacles,
    and from there the way to the goal. Without a goal the turn that it takes, and returning to where the robot has
    been, cost instead. It keeps to its choice until another one is cheaper by ``commit_m``.

    Once the goal is on floor that is known and within reach, the path leads there.

    The steering points to the farthest point of the path that the robot can drive to straight on. Where there is
    neither a frontier nor the goal, or where the path lies behind, the steering is a right angle: the robot turns on
    the spot.

    What moves and is about to reach the robot makes it drive out of the way: straight on or, with an angle of pi,
    straight back over floor that it knows, whichever is shorter. ``control.nonholonomic`` needs ``reversing`` for that.

    Where ``recovery`` is wired, the robot takes a frontier of any size if there is no other one, from when it is to try
    another way for the first time.

    References
    ----------
    .. [Y] B. Yamauchi, A Frontier-Based Approach for Autonomous Exploration, CIRA 1997.
    """

    robot_radius_m: float = param(0.2, gt=0.0, le=10.0, doc="radius of the robot's body")
    margin_m: float = param(0.05, ge=0.0, le=10.0, doc="distance to keep from obstacles beyond the radius")
    map_error_m: float = param(
        0.02,
        ge=0.0,
        le=10.0,
        doc="how much nearer than they are obstacles may be on the map; more squeezes through narrower gaps",
    )
    squeeze_m: float = param(
        0.12,
        ge=0.0,
        le=10.0,
        doc="by how much nearer still obstacles may be on the map, at the price of `touch_cost`",
    )
    touch_cost: float = param(
        40.0,
        ge=0.0,
        le=1000.0,
        doc="dimensionless: cost of a metre where obstacles are nearer by all of `squeeze_m`, in addition; "
        "in proportion where they are nearer by less of it",
    )
    unknown_margin_m: float = param(
        0.08, ge=0.0, le=10.0, doc="distance that the robot's centre keeps from floor that it has not seen"
    )
    narrow_cost: float = param(
        1.0,
        ge=0.0,
        le=1000.0,
        doc="dimensionless: cost of a metre that cannot keep `margin_m`, in addition to what nearness costs",
    )
    min_frontier_m2: float = param(0.15, ge=0.0, le=1e6, doc="unknown floor of a smaller area is not worth a visit")
    comfort_m: float = param(
        0.25, ge=0.001, le=10.0, doc="distance from obstacles beyond the radius from which nearness costs nothing"
    )
    near_cost: float = param(
        1.5,
        ge=0.0,
        le=1000.0,
        doc="dimensionless: cost of a metre along an obstacle, in addition to 1; more keeps to the middle",
    )
    look_ahead_m: float = param(0.6, gt=0.0, le=100_000.0, doc="distance of the farthest point of the path to head for")
    turn_cost_m: float = param(0.6, ge=0.0, le=100_000.0, doc="cost of a first turn by half a circle without a goal")
    back_cost_m: float = param(
        3.0, ge=0.0, le=100_000.0, doc="cost of a frontier where the robot has been, without a goal"
    )
    trail_m: float = param(
        10.0,
        ge=_TRAIL_STEP_M,
        le=1000.0,
        doc="how far back along its way the robot knows where it has been, without a goal; on a loop that is shorter, "
        "going on costs as much as turning round",
    )
    commit_m: float = param(
        0.4, ge=0.0, le=100_000.0, doc="by how much another frontier must be cheaper to be preferred"
    )
    goal_weight: float = param(
        2.0, ge=0.0, le=1e6, doc="dimensionless: cost of a metre between a frontier and the goal"
    )
    give_way_m: float = param(
        1.0,
        ge=0.0,
        le=100.0,
        doc="how far the robot drives, straight on or back, out of the way of what moves; 0: it does not",
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Forget where the robot has been."""
        self._trail: list[Point] = []
        self._chosen: Point | None = None
        self._spin = 1.0
        self._takes_any_size = False

    def step(
        self,
        map: LocalMap,  # noqa: A002  # the port's name
        goal: Latest[Goal],
        recovery: Latest[RecoveryState] = _NO_RECOVERY,
    ) -> Steering:
        """Return the steering along the path: no repulsive force, a guiding force of length 1."""
        self._remember(map)
        self._takes_any_size |= recovery.value is not None and recovery.value.doing == "other_way"
        return headed(self._theta_rad(map, goal.value))

    def _remember(self, map: LocalMap) -> None:  # noqa: A002
        here = (map.x_m, map.y_m)
        if not self._trail or math.dist(self._trail[-1], here) > _TRAIL_STEP_M:
            self._trail = [*self._trail[-round(self.trail_m / _TRAIL_STEP_M) :], here]

    def _theta_rad(self, map: LocalMap, goal: Goal | None) -> float:  # noqa: A002
        if self.give_way_m:
            aside_rad = out_of_the_way_rad(map, self.robot_radius_m + self.margin_m, self.give_way_m)
            if aside_rad is not None:
                return aside_rad
        price = self._price(map)
        way = self._way(map, goal, price)
        if way is None:
            self._chosen = None
            return self._spin * math.pi / 2
        self._chosen = way.end_m
        theta_rad = self._toward(map, way.path, price)
        if theta_rad:
            self._spin = math.copysign(1.0, theta_rad)
        return min(max(theta_rad, -math.pi / 2), math.pi / 2)

    def _way(self, map: LocalMap, goal: Goal | None, price: Doubles) -> Way | None:  # noqa: A002
        """Return the cheapest way to a frontier, None if there is none."""
        (row,), (col,) = map.cells_at(np.zeros(1), np.zeros(1))
        open_cells = self._open(map, int(row), int(col))
        known = open_cells & (map.unknown_m >= min(self.unknown_margin_m, float(map.unknown_m[row, col])))
        beyond = open_cells & ~known
        for min_m2 in (self.min_frontier_m2, 0.0)[: 1 + self._takes_any_size]:
            frontier = _wide(beyond, min_m2 / map.cell_m**2) & beside(known)
            paths = cheapest_paths((int(row), int(col)), np.where(known | frontier, price, math.inf), map.cell_m)
            end = None if goal is None else self._at_goal(map, goal, np.isfinite(paths.cost_m))
            if goal is not None and end is not None:
                return Way(_goal_m(map, goal), paths.to(*end))
            rows, cols = np.nonzero(frontier & np.isfinite(paths.cost_m))
            if len(rows):
                break
        else:
            return None
        x_m, y_m = map.places_m(rows, cols)
        cost_m = paths.cost_m[rows, cols] + self._cost_beyond_m(map, goal, x_m, y_m)
        best = self._best(x_m, y_m, cost_m)
        return Way((float(x_m[best]), float(y_m[best])), paths.to(int(rows[best]), int(cols[best])))

    def _open(self, map: LocalMap, row: int, col: int) -> Bools:  # noqa: A002
        """Return the cells where the robot touches nothing, and those by which it can leave what it touches now."""
        open_cells: Bools = map.obstacle_m >= self.robot_radius_m - self.map_error_m - self.squeeze_m
        reach = math.ceil((self.robot_radius_m + self.margin_m) / map.cell_m)
        near = (slice(max(row - reach, 0), row + reach + 1), slice(max(col - reach, 0), col + reach + 1))
        open_cells[near] |= map.obstacle_m[near] >= map.obstacle_m[row, col]
        return open_cells

    def _price(self, map: LocalMap) -> Doubles:  # noqa: A002
        """Return the cost of a metre at each cell: 1, and more near obstacles."""
        beyond_m = map.obstacle_m - self.robot_radius_m
        near = np.clip(1.0 - beyond_m / self.comfort_m, 0.0, 1.0)
        touching = np.clip((-self.map_error_m - beyond_m) / max(self.squeeze_m, _MIN_SQUEEZE_M), 0.0, 1.0)
        return np.asarray(
            1.0 + self.near_cost * near**2 + self.narrow_cost * (beyond_m < self.margin_m) + self.touch_cost * touching
        )

    def _cost_beyond_m(self, map: LocalMap, goal: Goal | None, x_m: Doubles, y_m: Doubles) -> Doubles:  # noqa: A002
        """Return the cost of what comes after points on the map: the way to the goal, or a return."""
        if goal is None:
            return self._cost_of_return_m(map, x_m, y_m)
        goal_x_m, goal_y_m = _goal_m(map, goal)
        return np.asarray(self.goal_weight * np.hypot(x_m - goal_x_m, y_m - goal_y_m))

    @staticmethod
    def _at_goal(map: LocalMap, goal: Goal, reached: Bools) -> tuple[int, int] | None:  # noqa: A002
        """Return the row and column of the goal if it is among the cells that are ``reached``."""
        x_m, y_m = _goal_m(map, goal)
        col, row = round((x_m - map.origin_x_m) / map.cell_m), round((y_m - map.origin_y_m) / map.cell_m)
        inside = 0 <= row < reached.shape[0] and 0 <= col < reached.shape[1]
        return (row, col) if inside and reached[row, col] else None

    def _best(self, x_m: Doubles, y_m: Doubles, cost_m: Doubles) -> int:
        """Return which point is cheapest; the last choice has `commit_m` less."""
        if self._chosen is not None:
            apart_m = np.hypot(x_m - self._chosen[0], y_m - self._chosen[1])
            cost_m = cost_m - self.commit_m * (apart_m < _SAME_M)
        return int(np.argmin(cost_m))

    def _cost_of_return_m(self, map: LocalMap, x_m: Doubles, y_m: Doubles) -> Doubles:  # noqa: A002
        turn_rad = apart_rad(np.arctan2(y_m - map.y_m, x_m - map.x_m), map.yaw_rad)
        cost_m = self.turn_cost_m * turn_rad / math.pi
        trail = np.array(self._trail[:-4] or self._trail[:1])
        apart_m = np.hypot(x_m[:, None] - trail[:, 0], y_m[:, None] - trail[:, 1]).min(axis=1)
        return np.asarray(cost_m + self.back_cost_m * np.clip(1.0 - apart_m / 1.0, 0.0, 1.0))

    def _toward(self, map: LocalMap, path: Indices, price: Doubles) -> float:  # noqa: A002
        """Return the angle from forward to the farthest point of the path to which a straight way leads.

        A straight way keeps ``margin_m`` from obstacles beyond the radius, or as much as the path does up to there, and
        does not cost more than the path.
        """
        x_m, y_m = map.places_m(path[:, 0], path[:, 1])
        away_m = np.hypot(x_m - map.x_m, y_m - map.y_m)
        along_m = np.hypot(np.diff(x_m, prepend=x_m[0]), np.diff(y_m, prepend=y_m[0]))
        cost_m = np.cumsum(along_m * price[path[:, 0], path[:, 1]])
        kept_m = np.minimum.accumulate(map.obstacle_m[path[:, 0], path[:, 1]])
        kept_m = np.minimum(kept_m, self.robot_radius_m + self.margin_m)
        last = min(2, len(path) - 1)
        for k in range(last, len(path)):
            if away_m[k] > self.look_ahead_m:
                break
            share = np.linspace(0.0, 1.0, max(2, math.ceil(away_m[k] / map.cell_m * 2)))
            cells = map.cells_of(map.x_m + share * (x_m[k] - map.x_m), map.y_m + share * (y_m[k] - map.y_m))
            if map.obstacle_m[cells][1:].min() < kept_m[k] or away_m[k] * price[cells].mean() > cost_m[k]:
                break
            last = k
        return math.remainder(math.atan2(y_m[last] - map.y_m, x_m[last] - map.x_m) - map.yaw_rad, 2 * math.pi)


def _goal_m(map: LocalMap, goal: Goal) -> Point:  # noqa: A002
    """Return the goal in the frame of the map."""
    bearing_rad, distance_m = map.yaw_rad + goal.bearing_rad, min(max(goal.distance_m, -_FAR_M), _FAR_M)
    return map.x_m + distance_m * math.cos(bearing_rad), map.y_m + distance_m * math.sin(bearing_rad)


def _wide(cells: Bools, min_cells: float) -> Bools:
    """Return the ``cells`` (rows, cols) that are in connected regions of at least so many."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(cells.view(np.uint8), connectivity=4)
    is_wide = stats[:, cv2.CC_STAT_AREA] >= min_cells
    is_wide[0] = False
    return np.asarray(is_wide[labels])
