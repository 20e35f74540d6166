"""Steering along the cheapest path to the frontier of what is known."""

from __future__ import annotations

import math
from functools import partial
from typing import NamedTuple

import cv2
import numpy as np

from graphnav import Goal, Latest, LocalMap, RecoveryState, Stage, Steering, param
from graphnav.arrays import Bools, Doubles, Floats, Indices
from graphnav_steer.giving_way import out_of_the_way_rad
from graphnav_steer.headings import apart_rad, headed
from graphnav_steer.local_paths import Floor, NearSearch, Window, beside, cell_below, connected

Point = tuple[float, float]

_NO_RECOVERY: Latest[RecoveryState] = Latest()
_TRAIL_STEP_M = 0.1
_FAR_M = 1e6
"""A goal that is farther away counts as this far: only its bearing matters."""
_MIN_SQUEEZE_M = 1e-6
_BACK_M = 1.0
"""Frontiers farther from the trail than this are new; nearer ones cost in proportion."""
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
        self._search = NearSearch()

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
        way = self._way(map, goal)
        if way is None:
            self._chosen = None
            return self._spin * math.pi / 2
        self._chosen = way.end_m
        theta_rad = self._toward(map, way.path)
        if theta_rad:
            self._spin = math.copysign(1.0, theta_rad)
        return min(max(theta_rad, -math.pi / 2), math.pi / 2)

    def _way(self, map: LocalMap, goal: Goal | None) -> Way | None:  # noqa: A002
        """Return the cheapest way to a frontier, None if there is none."""
        robot = cell_below(map)
        open_cells = self._open(map, *robot)
        known = open_cells & (map.unknown_m >= min(self.unknown_margin_m, float(map.unknown_m[robot])))
        beyond = open_cells & ~known
        rims = np.stack(np.divmod(np.flatnonzero(beyond & beside(known)), known.shape[1]), axis=1)
        for min_m2 in (self.min_frontier_m2, 0.0)[: 1 + self._takes_any_size]:
            frontier = rims[_wide(beyond, rims, min_m2 / map.cell_m**2)]
            passable = known.copy()
            passable[frontier[:, 0], frontier[:, 1]] = True
            reached, window = connected(robot, passable)
            end = None if goal is None else self._at_goal(map, goal, reached)
            if goal is not None and end is not None:
                floor = Floor(reached, window, partial(self._prices, map, reached), map.cell_m)
                _, path = self._search.cheapest(robot, floor, np.array([end]), np.zeros(1))
                return Way(_goal_m(map, goal), path)
            frontier = frontier[reached[frontier[:, 0], frontier[:, 1]]]
            if len(frontier):
                break
        else:
            return None
        x_m, y_m = map.places_m(*frontier.T)
        floor = Floor(reached, window, partial(self._prices, map, reached), map.cell_m)
        best, path = self._search.cheapest(robot, floor, frontier, self._cost_beyond_m(map, goal, x_m, y_m))
        return Way((float(x_m[best]), float(y_m[best])), path)

    def _open(self, map: LocalMap, row: int, col: int) -> Bools:  # noqa: A002
        """Return the cells where the robot touches nothing, and those by which it can leave what it touches now."""
        open_cells: Bools = map.obstacle_m >= self.robot_radius_m - self.map_error_m - self.squeeze_m
        reach = math.ceil((self.robot_radius_m + self.margin_m) / map.cell_m)
        near = (slice(max(row - reach, 0), row + reach + 1), slice(max(col - reach, 0), col + reach + 1))
        open_cells[near] |= map.obstacle_m[near] >= map.obstacle_m[row, col]
        return open_cells

    def _prices(self, map: LocalMap, cells: Bools, part: Window) -> Doubles:  # noqa: A002
        """Return the cost of a metre on the ``cells`` of a part of the map."""
        return self._price(map.obstacle_m[part][cells[part]])

    def _price(self, obstacle_m: Floats) -> Doubles:
        """Return the cost of a metre so far from obstacles: 1, and more near them."""
        beyond_m = obstacle_m - self.robot_radius_m
        near = np.clip(1.0 - beyond_m / self.comfort_m, 0.0, 1.0)
        touching = np.clip((-self.map_error_m - beyond_m) / max(self.squeeze_m, _MIN_SQUEEZE_M), 0.0, 1.0)
        return np.asarray(
            1.0 + self.near_cost * near**2 + self.narrow_cost * (beyond_m < self.margin_m) + self.touch_cost * touching
        )

    def _cost_beyond_m(self, map: LocalMap, goal: Goal | None, x_m: Doubles, y_m: Doubles) -> Doubles:  # noqa: A002
        """Return the cost of what comes after points on the map: the way to the goal, or a return.

        Near the last choice it is `commit_m` less.
        """
        if goal is None:
            cost_m = self._cost_of_return_m(map, x_m, y_m)
        else:
            goal_x_m, goal_y_m = _goal_m(map, goal)
            cost_m = np.asarray(self.goal_weight * np.hypot(x_m - goal_x_m, y_m - goal_y_m))
        if self._chosen is not None:
            cost_m -= self.commit_m * (np.hypot(x_m - self._chosen[0], y_m - self._chosen[1]) < _SAME_M)
        return cost_m

    @staticmethod
    def _at_goal(map: LocalMap, goal: Goal, reached: Bools) -> tuple[int, int] | None:  # noqa: A002
        """Return the row and column of the goal if it is among the cells that are ``reached``."""
        x_m, y_m = _goal_m(map, goal)
        col, row = round((x_m - map.origin_x_m) / map.cell_m), round((y_m - map.origin_y_m) / map.cell_m)
        inside = 0 <= row < reached.shape[0] and 0 <= col < reached.shape[1]
        return (row, col) if inside and reached[row, col] else None

    def _cost_of_return_m(self, map: LocalMap, x_m: Doubles, y_m: Doubles) -> Doubles:  # noqa: A002
        turn_rad = apart_rad(np.arctan2(y_m - map.y_m, x_m - map.x_m), map.yaw_rad)
        cost_m = self.turn_cost_m * turn_rad / math.pi
        trail_x_m, trail_y_m = np.array(self._trail[:-4] or self._trail[:1]).T
        # Most of the trail is too far away from all of the points to cost anything.
        near = (trail_x_m > x_m.min() - _BACK_M) & (trail_x_m < x_m.max() + _BACK_M)
        near &= (trail_y_m > y_m.min() - _BACK_M) & (trail_y_m < y_m.max() + _BACK_M)
        apart_m = np.hypot(x_m[:, None] - trail_x_m[near], y_m[:, None] - trail_y_m[near])
        nearest_m = apart_m.min(axis=1, initial=_BACK_M)
        return np.asarray(cost_m + self.back_cost_m * (1.0 - nearest_m / _BACK_M))

    def _toward(self, map: LocalMap, path: Indices) -> float:  # noqa: A002
        """Return the angle from forward to the farthest point of the path to which a straight way leads.

        A straight way keeps ``margin_m`` from obstacles beyond the radius, or as much as the path does up to there, and
        does not cost more than the path.
        """
        rows, cols = path.T
        x_m, y_m = map.places_m(rows, cols)
        away_m = np.hypot(x_m - map.x_m, y_m - map.y_m)
        last = min(2, len(path) - 1)
        is_far = np.append(away_m[last:] > self.look_ahead_m, True)
        end = last + int(np.argmax(is_far))
        path_m = map.obstacle_m[rows[:end], cols[:end]]
        along_m = np.hypot(x_m[1:end] - x_m[: max(end - 1, 0)], y_m[1:end] - y_m[: max(end - 1, 0)])
        cost_m = np.append(0.0, np.cumsum(along_m * self._price(path_m[1:])))
        kept_m = np.minimum(np.minimum.accumulate(path_m), self.robot_radius_m + self.margin_m)
        ends, share = _shares(np.maximum(np.ceil(away_m[last:end] / map.cell_m * 2).astype(np.intp), 2))
        counts = np.diff(ends)
        cells = map.cells_of(
            map.x_m + share * np.repeat(x_m[last:end] - map.x_m, counts),
            map.y_m + share * np.repeat(y_m[last:end] - map.y_m, counts),
        )
        straight_m = map.obstacle_m[cells]
        price = self._price(straight_m)
        for k, first, after in zip(range(last, end), ends[:-1], ends[1:], strict=True):
            if straight_m[first + 1 : after].min() < kept_m[k] or away_m[k] * price[first:after].mean() > cost_m[k]:
                break
            last = k
        return math.remainder(math.atan2(y_m[last] - map.y_m, x_m[last] - map.x_m) - map.yaw_rad, 2 * math.pi)


def _goal_m(map: LocalMap, goal: Goal) -> Point:  # noqa: A002
    """Return the goal in the frame of the map."""
    bearing_rad, distance_m = map.yaw_rad + goal.bearing_rad, min(max(goal.distance_m, -_FAR_M), _FAR_M)
    return map.x_m + distance_m * math.cos(bearing_rad), map.y_m + distance_m * math.sin(bearing_rad)


def _shares(counts: Indices) -> tuple[Indices, Doubles]:
    """Return shares from 0 to 1 of ways, so many (n,) of each, one way after another, and where each begins and ends.

    The places where they begin and end are (n + 1,).
    """
    ends = np.concatenate(([0], np.cumsum(counts)))
    share = (np.arange(ends[-1]) - np.repeat(ends[:-1], counts)) * np.repeat(1.0 / (counts - 1), counts)
    share[ends[1:] - 1] = 1.0
    return ends, share


def _wide(cells: Bools, places: Indices, min_cells: float) -> Bools:
    """Return which places (n, 2) are in connected regions of at least so many ``cells`` (rows, cols)."""
    new, wide, small = 1, 2, 3
    filled = cells.astype(np.uint8)
    rows, cols = places.T
    while (is_new := filled[rows, cols] == new).any():
        row, col = places[np.argmax(is_new)].tolist()
        area = cv2.floodFill(filled, None, (col, row), wide, flags=4)[0]
        if area < min_cells:
            cv2.floodFill(filled, None, (col, row), small, flags=4)
    return np.asarray(filled[rows, cols] == wide)
