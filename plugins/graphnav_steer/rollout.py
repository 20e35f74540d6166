"""Speeds by simulating many of them for a while: trajectory rollout with a dynamic window."""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np

from graphnav import Goal, Latest, LocalMap, Motion, Stage, Twist, param
from graphnav.arrays import Doubles, Indices
from graphnav_steer.local_paths import Paths, cell_below, cheapest_paths, load_search
from graphnav_steer.speed_window import measured_speeds, window

_STEP_S = 0.05
"""Step of the simulation."""
_FAR_M = 1e6
"""A goal that is farther away counts as this far: only its bearing matters."""
_TOUCH_M = 0.005
"""How much nearer to what it touches already the robot may come."""
_TURN_AGAIN_M = 0.05
"""Distance after which the robot may turn on the spot to the other side (oscillation_reset_dist)."""
_ESCAPE_M, _ESCAPE_RAD = 0.1, 0.1
"""Displacement or turn that ends an escape (escape_reset_dist, escape_reset_theta)."""
_TIE_M = 1e-9
_NAVFN_COST = 0.8 * 252 / 50
"""Cost of a metre at the inscribed radius, in addition to 1: cost_factor and neutral_cost of move_base's navfn."""


class _Turn(NamedTuple):
    """A pose on the map at which the robot turned on the spot to a side (1 left, -1 right) or backed up (0)."""

    x_m: float
    y_m: float
    yaw_rad: float
    side: float


class _Rolled(NamedTuple):
    """Trajectories: speeds, and their points in the robot's frame, (trajectories, steps); the heading at the end."""

    v_mps: Doubles
    omega_radps: Doubles
    forward_m: Doubles
    left_m: Doubles
    yaw_rad: Doubles


class _Costs(NamedTuple):
    """Grids that trajectories are scored by, each (rows, cols) of the map.

    ``away_m``: distance of the nearest obstacle. ``path_m``: of the planned path. ``goal_m``: way to the path's end,
    infinite where no way leads there.
    """

    away_m: Doubles
    path_m: Doubles
    goal_m: Doubles


class Rollout(Stage):
    """Speeds by trajectory rollout [GK] over a dynamic window [DWA], as move_base does with TrajectoryPlanner.

    The defaults are those that the BARN challenge ships as its example, with a disc as body. A path to the goal is
    planned on the map, where unknown floor counts as free and the goal beyond the map is reached over its rim; a metre
    costs more near obstacles. Of all speeds that the robot can have after one period, a grid is simulated for
    ``ahead_s``. A trajectory that touches an obstacle is out. The others cost ``path_cost`` for each metre that they
    end beside the path, ``goal_cost`` for each metre that is left to the path's end, and up to ``near_cost_m`` where
    their centre is nearest to an obstacle (move_base scores a disc by its centre, too). Turning on the spot is an
    alternative where it is not dearer: to where the way is shorter, and not back to the side that it came from before
    the robot has driven 5 cm.

    Where no trajectory is free the robot backs up straight until it has moved by 0.1 m or turned, as long as the map
    shows no obstacle behind; else it turns on the spot, as move_base recovers. Without a goal it wants to go straight
    on.

    In place of a direction for a ``control`` stage it publishes the command itself. Its speeds now are those of
    ``motion``; without it the window is about standstill.

    References
    ----------
    .. [GK] B. P. Gerkey, K. Konolige, Planning and Control in Unstructured Terrain, ICRA Workshop on Path Planning on
       Costmaps, 2008.
    .. [DWA] D. Fox, W. Burgard, S. Thrun, The Dynamic Window Approach to Collision Avoidance, IEEE Robotics and
       Automation Magazine 4(1), 1997.
    """

    robot_radius_m: float = param(0.2, gt=0.0, le=10.0, doc="radius of the robot's body")
    margin_m: float = param(0.0, ge=0.0, le=10.0, doc="distance to keep from obstacles beyond the radius")
    max_speed_mps: float = param(0.5, gt=0.0, le=1000.0, doc="maximum forward speed (max_vel_x of the challenge)")
    min_speed_mps: float = param(
        0.1, gt=0.0, le=1000.0, doc="minimum forward speed, unless it turns on the spot (min_vel_x)"
    )
    escape_mps: float = param(
        0.5, ge=0.0, le=1000.0, doc="speed backwards where no trajectory is free (escape_vel); 0 never backs up"
    )
    max_turn_radps: float = param(1.57, gt=0.0, le=1000.0, doc="maximum turning rate (max_vel_theta)")
    min_turn_radps: float = param(
        0.314, ge=0.0, le=1000.0, doc="minimum turning rate on the spot (min_in_place_vel_theta)"
    )
    max_accel_mps2: float = param(10.0, gt=0.0, le=1e6, doc="acceleration that the window allows (acc_lim_x)")
    max_turn_accel_radps2: float = param(
        20.0, gt=0.0, le=1e6, doc="angular acceleration that the window allows (acc_lim_theta)"
    )
    period_s: float = param(
        0.1, gt=0.0, le=60.0, doc="time between two commands, by which the window is as wide (controller_frequency)"
    )
    ahead_s: float = param(2.0, ge=_STEP_S, le=60.0, doc="time that is simulated (sim_time)")
    speed_samples: int = param(6, ge=2, le=200, doc="number of forward speeds (vx_samples)")
    turn_samples: int = param(20, ge=2, le=200, doc="number of turning rates, beside 0 (vtheta_samples)")
    path_cost: float = param(
        0.75, ge=0.0, le=1000.0, doc="dimensionless: cost of a metre beside the path (pdist_scale); more keeps to it"
    )
    goal_cost: float = param(
        1.0, ge=0.0, le=1000.0, doc="dimensionless: cost of a metre to the path's end (gdist_scale); more drives faster"
    )
    near_cost_m: float = param(
        1.27,
        ge=0.0,
        le=1000.0,
        doc="cost of touching an obstacle; less in the inflation (occdist_scale 0.1, times 253 and 0.05 m a cell)",
    )
    inflation_m: float = param(
        0.3,
        ge=0.0,
        le=100.0,
        doc="distance of the centre from obstacles from which nearness costs nothing (inflation_radius)",
    )
    inflation_per_m: float = param(
        10.0,
        ge=0.0,
        le=1e4,
        doc="1/m: rate by which the cost falls with the distance beyond the radius (cost_scaling_factor)",
    )
    heading_ahead_m: float = param(
        0.325, ge=0.0, le=100.0, doc="distance of the point by which turns on the spot are compared (heading_lookahead)"
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Forget turns on the spot and escapes."""
        load_search()
        self._turn: _Turn | None = None
        self._escape: _Turn | None = None

    def step(self, map: LocalMap, goal: Latest[Goal], motion: Latest[Motion]) -> Twist:  # noqa: A002  # the port's name
        """Return the command."""
        costs = self._costs(map, goal.value or Goal(bearing_rad=0.0, distance_m=_FAR_M))
        now = measured_speeds(motion.value)
        forward, turns = self._sampled(now)
        if self._is_escaping(map):
            forward = forward[:, :0]
        rolled = self._rolled(np.concatenate([forward, turns], axis=1), now)
        cost = self._scores(map, costs, rolled)
        count = forward.shape[1]
        best = int(np.argmin(cost[:count])) if count else None
        best_cost = math.inf if best is None else float(cost[best])
        spin = self._spin(map, costs, rolled, np.flatnonzero(cost <= best_cost + _TIE_M), count)
        if spin is not None:
            self._turn = _Turn(map.x_m, map.y_m, map.yaw_rad, math.copysign(1.0, rolled.omega_radps[spin]))
            return Twist(v_mps=0.0, omega_radps=float(rolled.omega_radps[spin]))
        if best is None or not math.isfinite(best_cost):
            return self._recovered(map)
        return Twist(v_mps=float(rolled.v_mps[best]), omega_radps=float(rolled.omega_radps[best]))

    def _radius_m(self) -> float:
        return self.robot_radius_m + self.margin_m

    def _costs(self, map: LocalMap, goal: Goal) -> _Costs:  # noqa: A002
        """Return what trajectories are scored by."""
        radius_m = self._radius_m()
        # Distances on the map are to the rim of a cell, in which the obstacle is somewhere.
        away_m = np.asarray(map.obstacle_m + map.cell_m / 2, np.float64)
        row, col = cell_below(map)
        free = away_m >= radius_m
        reach = math.ceil(radius_m / map.cell_m)
        near = (slice(max(row - reach, 0), row + reach + 1), slice(max(col - reach, 0), col + reach + 1))
        free[near] |= away_m[near] >= away_m[row, col]
        paths = cheapest_paths((row, col), free, 1.0 + _NAVFN_COST * self._inflated(away_m[free]), map.cell_m)
        end = _end(map, goal, paths)
        off_path = np.ones(free.shape, np.uint8)
        off_path[tuple(paths.to(*end).T)] = 0
        path_m = map.cell_m * cv2.distanceTransform(off_path, cv2.DIST_L2, cv2.DIST_MASK_PRECISE).astype(np.float64)
        return _Costs(away_m, path_m, cheapest_paths(end, free, np.ones(np.count_nonzero(free)), map.cell_m).cost_m)

    def _inflated(self, away_m: Doubles) -> Doubles:
        """Return what nearness costs at these distances of the centre from obstacles: 1 in touch, then less, then 0."""
        cost = np.exp(-self.inflation_per_m * np.maximum(away_m - self._radius_m(), 0.0))
        return np.asarray(cost * (away_m <= self.inflation_m))

    def _sampled(self, now: tuple[float, float]) -> tuple[Doubles, Doubles]:
        """Return the speeds of the window, (2, n): those that drive forward, and turns on the spot."""
        (v_mps, omega_radps), change_radps = now, self.max_turn_accel_radps2 * self.period_s
        high_mps = max(self.max_speed_mps, self.min_speed_mps)
        low_mps, high_mps = window(v_mps, self.max_accel_mps2 * self.period_s, self.min_speed_mps, high_mps)
        low_radps, high_radps = window(omega_radps, change_radps, -self.max_turn_radps, self.max_turn_radps)
        rates = np.linspace(low_radps, high_radps, self.turn_samples)
        speeds = np.linspace(low_mps, high_mps, self.speed_samples)
        forward = np.stack(np.meshgrid(speeds, np.append(0.0, rates), indexing="ij")).reshape(2, -1)
        rates = rates[np.abs(rates) > (high_radps - low_radps) / (self.turn_samples - 1)]
        rates = np.copysign(np.maximum(np.abs(rates), self.min_turn_radps), rates)
        return forward, np.stack([np.zeros_like(rates), rates])

    def _rolled(self, speeds: Doubles, now: tuple[float, float]) -> _Rolled:
        """Simulate speeds (2, n) for ``ahead_s``, from those of now within the accelerations."""
        time_s = _STEP_S * np.arange(1.0, round(self.ahead_s / _STEP_S) + 1)
        v_mps = _approached(now[0], speeds[0], self.max_accel_mps2 * time_s)
        omega_radps = _approached(now[1], speeds[1], self.max_turn_accel_radps2 * time_s)
        yaw_rad = _STEP_S * np.cumsum(omega_radps, axis=1)
        midway_rad = yaw_rad - omega_radps * (_STEP_S / 2)
        forward_m = _STEP_S * np.cumsum(v_mps * np.cos(midway_rad), axis=1)
        left_m = _STEP_S * np.cumsum(v_mps * np.sin(midway_rad), axis=1)
        return _Rolled(speeds[0], speeds[1], forward_m, left_m, yaw_rad[:, -1])

    def _scores(self, map: LocalMap, costs: _Costs, rolled: _Rolled) -> Doubles:  # noqa: A002
        """Return the cost of each trajectory, infinite where it touches or leads nowhere."""
        radius_m = self._radius_m()
        cells = map.cells_at(rolled.forward_m, rolled.left_m)
        here_m = costs.away_m[cell_below(map)]
        away_m = costs.away_m[cells].min(axis=1)
        goal_m = costs.goal_m[cells]
        may_go = (away_m >= np.minimum(radius_m, here_m - _TOUCH_M)) & np.isfinite(goal_m).all(axis=1)
        path_m = costs.path_m[cells[0][:, -1], cells[1][:, -1]]
        cost = self.path_cost * path_m + self.goal_cost * goal_m[:, -1] + self.near_cost_m * self._inflated(away_m)
        return np.where(may_go, cost, math.inf)

    def _spin(
        self,
        map: LocalMap,  # noqa: A002
        costs: _Costs,
        rolled: _Rolled,
        cheap: Indices,
        first: int,
    ) -> int | None:
        """Return the turn on the spot among the ``cheap`` trajectories whose heading has the shortest way to go.

        ``first``: the first trajectory that is a turn on the spot.
        """
        spins = cheap[cheap >= first]
        if self._turn is not None:
            if math.hypot(map.x_m - self._turn.x_m, map.y_m - self._turn.y_m) > _TURN_AGAIN_M:
                self._turn = None
            else:
                spins = spins[rolled.omega_radps[spins] * self._turn.side > 0.0]
        if not len(spins):
            return None
        ahead = [self.heading_ahead_m * f(rolled.yaw_rad[spins]) for f in (np.cos, np.sin)]
        return int(spins[np.argmin(costs.goal_m[map.cells_at(*ahead)])])

    def _recovered(self, map: LocalMap) -> Twist:  # noqa: A002
        """Return the command where no trajectory is free: back, or a turn on the spot."""
        back_m = np.linspace(0.0, _ESCAPE_M, 5)
        away_m = map.obstacle_m_at(-back_m, np.zeros(5))
        if self.escape_mps and away_m.min() >= away_m[0] - _TOUCH_M:
            self._escape = _Turn(map.x_m, map.y_m, map.yaw_rad, 0.0)
            return Twist(v_mps=-self.escape_mps, omega_radps=0.0)
        side = self._turn.side if self._turn is not None else 1.0
        return Twist(v_mps=0.0, omega_radps=side * self.max_turn_radps)

    def _is_escaping(self, map: LocalMap) -> bool:  # noqa: A002
        """Whether the robot has backed up and neither moved nor turned much since."""
        if self._escape is None:
            return False
        moved_m = math.hypot(map.x_m - self._escape.x_m, map.y_m - self._escape.y_m)
        turned_rad = math.remainder(map.yaw_rad - self._escape.yaw_rad, 2 * math.pi)
        if moved_m > _ESCAPE_M or abs(turned_rad) > _ESCAPE_RAD:
            self._escape = None
        return self._escape is not None


def _end(map: LocalMap, goal: Goal, paths: Paths) -> tuple[int, int]:  # noqa: A002
    """Return the row and column where the path ends: next to the goal, or on the rim of the map on the way there."""
    bearing_rad, distance_m = map.yaw_rad + goal.bearing_rad, min(goal.distance_m, _FAR_M)
    x_m, y_m = map.x_m + distance_m * math.cos(bearing_rad), map.y_m + distance_m * math.sin(bearing_rad)
    rows, cols = paths.cost_m.shape
    col, row = (x_m - map.origin_x_m) / map.cell_m, (y_m - map.origin_y_m) / map.cell_m
    at_row, at_col = np.nonzero(np.isfinite(paths.cost_m))
    beyond_m = map.cell_m * np.hypot(at_row - row, at_col - col)
    if not (0 <= row <= rows - 1 and 0 <= col <= cols - 1):
        on_rim = (at_row == 0) | (at_row == rows - 1) | (at_col == 0) | (at_col == cols - 1)
        if on_rim.any():
            at_row, at_col = at_row[on_rim], at_col[on_rim]
            beyond_m = beyond_m[on_rim] + paths.cost_m[at_row, at_col]
    best = int(np.argmin(beyond_m))
    return int(at_row[best]), int(at_col[best])


def _approached(now: float, wanted: Doubles, max_change: Doubles) -> Doubles:
    """Return the speeds (n, steps) on the way to the wanted ones (n,), changed by at most this (steps,)."""
    change = wanted[:, None] - now
    return np.asarray(now + np.clip(change, -max_change, max_change))
