"""Speeds by the dynamic window approach, on a local map."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import cv2
import numpy as np

from graphnav import Goal, Latest, LocalMap, Motion, Stage, Steering, Twist, param
from graphnav.arrays import Bools, Doubles
from graphnav_steer.headings import headed
from graphnav_steer.longest_way import Costs, LongestWay
from graphnav_steer.speed_window import measured_speeds, window

_MIN_SPEED_MPS = 0.01
"""A slower robot stands."""
_AWAY_HEADINGS = 72
_AWAY_COSTS = Costs(turn=0.25, change=0.3, goal=0.5)


class DwaOutputs(NamedTuple):
    """Outputs of `Dwa`; ``steering`` is the direction for which `control.nonholonomic` would give these speeds."""

    steering: Steering
    twist: Twist


class _Window(NamedTuple):
    """Pairs of speeds, each (speeds, turns)."""

    v_mps: Doubles
    omega_radps: Doubles


class _Ways(NamedTuple):
    """How far arcs lead, m: until the robot touches an obstacle, and on floor that it has seen, too."""

    touch_m: Doubles
    known_m: Doubles


class Dwa(Stage):
    """Dynamic window approach [DWA]: of the speeds that the robot can have next, those that promise most.

    Candidates are all pairs of a grid over the window: forward speed and turning rate that the robot can have after
    ``period_s``, within its accelerations. Each drives along an arc. A pair is admissible if the robot can stop on that
    arc before it touches an obstacle, and before floor that it has not seen. The others score

    ``heading_weight * heading + way_weight * way + speed_weight * speed``,

    each from 0 to 1: how well the robot is headed for its target once it has driven for ``period_s`` and stopped; how
    far it drives on the arc before it touches an obstacle, of ``reach_m``; and how fast it is. The score is smoothed
    over neighbouring turning rates. The target is the beacon, or else straight ahead. Standing and turning on the spot
    count as the straight way in the direction that the robot then has.

    Where no forward speed is admissible the robot brakes, as well directed as it can, and once it stands turns on the
    spot, away from what is ahead, and goes on to the same side until one is. It plans nothing beyond an arc: it does
    not leave a dead end in which its target lies ahead.

    In place of a ``control`` stage it publishes the command, ``twist``. Its speeds now are those of ``motion``; without
    it the window is about standstill.

    References
    ----------
    .. [DWA] D. Fox, W. Burgard, S. Thrun, The Dynamic Window Approach to Collision Avoidance, IEEE Robotics and
       Automation Magazine 4(1), 1997: the window, admissible speeds, the objective and turning away from obstacles.
    """

    robot_radius_m: float = param(0.2, gt=0.0, le=10.0, doc="radius of the robot's body")
    margin_m: float = param(0.05, ge=0.0, le=10.0, doc="distance to keep from obstacles beyond the radius")
    unknown: Literal["obstacle", "free"] = param(
        "obstacle", doc="what cells that were never judged count as; free drives where nothing was seen"
    )
    max_speed_mps: float = param(0.3, gt=0.0, le=1000.0, doc="maximum forward speed")
    max_turn_radps: float = param(1.2, gt=0.0, le=1000.0, doc="maximum turning rate")
    max_accel_mps2: float = param(2.0, gt=0.0, le=1e6, doc="acceleration that the window allows")
    max_turn_accel_radps2: float = param(8.0, gt=0.0, le=1e6, doc="angular acceleration that the window allows")
    max_decel_mps2: float = param(0.5, gt=0.0, le=100.0, doc="deceleration to count on before obstacles")
    reaction_s: float = param(
        0.25, ge=0.0, le=60.0, doc="time from what the camera sees to the brakes: images and latency"
    )
    period_s: float = param(
        0.25,
        gt=0.0,
        le=60.0,
        doc="time in which the robot reaches the speeds of the window, and after which its heading is judged",
    )
    speed_samples: int = param(7, ge=2, le=200, doc="number of forward speeds")
    turn_samples: int = param(21, ge=2, le=200, doc="number of turning rates, beside 0")
    reach_m: float = param(1.0, gt=0.0, le=100.0, doc="length from which a free arc counts as entirely free")
    heading_weight: float = param(
        0.8, ge=0.0, le=1000.0, doc="dimensionless: weight of the direction; more turns to the target sooner"
    )
    way_weight: float = param(
        0.4, ge=0.0, le=1000.0, doc="dimensionless: weight of the way; more keeps away from obstacles ahead"
    )
    speed_weight: float = param(0.4, ge=0.0, le=1000.0, doc="dimensionless: weight of the forward speed")

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Forget turns away from obstacles."""
        self._side = 0.0
        half = np.arange(_AWAY_HEADINGS) - _AWAY_HEADINGS // 2
        self._headings_rad = half * 2 * math.pi / _AWAY_HEADINGS
        self._longest = LongestWay(self._headings_rad, 0.0, _AWAY_COSTS)

    def step(self, map: LocalMap, goal: Latest[Goal], motion: Latest[Motion]) -> DwaOutputs:  # noqa: A002  # the port's name
        """Return the command, and the direction that it means."""
        pairs = self._window(motion.value)
        ways = self._ways(map, pairs)
        allowed = self._can_stop(pairs, ways.known_m)
        if not (allowed & (pairs.v_mps >= _MIN_SPEED_MPS)).any():
            if pairs.v_mps.min() < _MIN_SPEED_MPS:
                return self._published(0.0, self._side_away(map, goal.value) * self.max_turn_radps)
            allowed = pairs.v_mps <= pairs.v_mps.min()
        self._side = 0.0
        score = _smoothed(self._score(pairs, ways.touch_m, goal.value), allowed)
        best = np.unravel_index(int(np.argmax(score)), score.shape)
        return self._published(float(pairs.v_mps[best]), float(pairs.omega_radps[best]))

    def _published(self, v_mps: float, omega_radps: float) -> DwaOutputs:
        theta_rad = math.atan2(omega_radps / self.max_turn_radps, v_mps / self.max_speed_mps)
        return DwaOutputs(headed(theta_rad), Twist(v_mps=v_mps, omega_radps=omega_radps))

    def _window(self, motion: Motion | None) -> _Window:
        """Return the pairs of speeds that the robot can have next."""
        v_mps, omega_radps = measured_speeds(motion)
        change_mps = self.max_accel_mps2 * self.period_s
        change_radps = self.max_turn_accel_radps2 * self.period_s
        low, high = window(omega_radps, change_radps, -self.max_turn_radps, self.max_turn_radps)
        speeds = np.linspace(*window(v_mps, change_mps, 0.0, self.max_speed_mps), self.speed_samples)
        turns = np.linspace(low, high, self.turn_samples)
        if low < 0.0 < high:
            turns = np.sort(np.append(turns, 0.0))
        return _Window(*np.meshgrid(speeds, turns, indexing="ij"))

    def _ways(self, map: LocalMap, pairs: _Window) -> _Ways:  # noqa: A002
        """Return how far the arc of each pair leads, (speeds, turns)."""
        drives = pairs.v_mps >= _MIN_SPEED_MPS
        per_m = np.where(drives, pairs.omega_radps / np.maximum(pairs.v_mps, _MIN_SPEED_MPS), 0.0)
        return self._on_arcs(map, per_m, np.where(drives, 0.0, self._turned_rad(pairs)))

    def _on_arcs(self, map: LocalMap, per_m: Doubles, begin_rad: Doubles) -> _Ways:  # noqa: A002
        """Return how far arcs of a curvature (any shape) that begin in a direction lead, at most as far as counts.

        That is ``reach_m``, or the way in which the robot stops from its maximum speed.
        """
        stop_m = self.max_speed_mps * (self.reaction_s + self.max_speed_mps / (2 * self.max_decel_mps2))
        along_m = map.cell_m / 2 * np.arange(math.ceil(2 * max(self.reach_m, stop_m) / map.cell_m) + 2)
        turned_rad = per_m[..., None] * along_m / 2
        # The chord of an arc, and its direction, which is that of its middle.
        chord_m = along_m * np.sinc(turned_rad / math.pi)
        at_rad = begin_rad[..., None] + turned_rad
        forward_m, left_m = chord_m * np.cos(at_rad), chord_m * np.sin(at_rad)
        near_m = map.obstacle_m_at(forward_m, left_m)
        free = near_m >= np.minimum(self.robot_radius_m + self.margin_m, near_m[..., :1] - map.cell_m / 8)
        known = free if self.unknown == "free" else free & (map.unknown_m_at(forward_m, left_m) > 0.0)
        return _Ways(*(map.cell_m / 2 * _steps(one) for one in (free, known)))

    def _turned_rad(self, pairs: _Window) -> Doubles:
        """Return by how much the robot has turned when it has driven for ``period_s`` and then stopped turning."""
        stopping_s = np.abs(pairs.omega_radps) / (2 * self.max_turn_accel_radps2)
        return np.asarray(pairs.omega_radps * (self.period_s + stopping_s))

    def _can_stop(self, pairs: _Window, way_m: Doubles) -> Bools:
        """Return from which speeds the robot stops within its free way, turning rates included."""
        waste_mps = self.max_decel_mps2 * self.reaction_s
        safe_mps = np.sqrt(waste_mps**2 + 2 * self.max_decel_mps2 * way_m) - waste_mps
        drives = pairs.v_mps >= _MIN_SPEED_MPS
        angle_rad = way_m * np.abs(pairs.omega_radps) / np.maximum(pairs.v_mps, _MIN_SPEED_MPS)
        turns_in_time = pairs.omega_radps**2 <= 2 * self.max_turn_accel_radps2 * angle_rad
        return ~drives | (pairs.v_mps <= safe_mps) & turns_in_time

    def _score(self, pairs: _Window, way_m: Doubles, goal: Goal | None) -> Doubles:
        """Return what each pair promises, (speeds, turns)."""
        stop_m = pairs.v_mps * (self.period_s + pairs.v_mps / (2 * self.max_accel_mps2))
        turned_rad = self._turned_rad(pairs)
        forward_m, left_m = stop_m * np.cos(turned_rad / 2), stop_m * np.sin(turned_rad / 2)
        target_rad = np.zeros_like(turned_rad)
        if goal is not None:
            goal_m = [goal.distance_m * f(goal.bearing_rad) for f in (math.cos, math.sin)]
            target_rad = np.arctan2(goal_m[1] - left_m, goal_m[0] - forward_m)
        aside_rad = np.abs(np.remainder(target_rad - turned_rad + math.pi, 2 * math.pi) - math.pi)
        return np.asarray(
            self.heading_weight * (1.0 - aside_rad / math.pi)
            + self.way_weight * np.minimum(way_m / self.reach_m, 1.0)
            + self.speed_weight * pairs.v_mps / self.max_speed_mps
        )

    def _side_away(self, map: LocalMap, goal: Goal | None) -> float:  # noqa: A002
        """Return the side to turn to, 1 left or -1 right: where the longest way is free, then the same again."""
        if not self._side:
            ways_m = self._on_arcs(map, np.zeros(_AWAY_HEADINGS), np.asarray(self._headings_rad)).touch_m
            goal_rad = None if goal is None else goal.bearing_rad
            self._side = math.copysign(
                1.0, self._longest.theta_rad(np.minimum(ways_m, self.reach_m), goal_rad, map.yaw_rad)
            )
        return self._side


def _steps(free: Bools) -> Doubles:
    """Return how many steps after the first one are free until one is not, along the last axis."""
    return np.asarray(np.logical_and.accumulate(free[..., 1:], axis=-1).sum(axis=-1, dtype=np.float64))


def _smoothed(score: Doubles, counts: Bools) -> Doubles:
    """Return the mean over each pair and its neighbours that count, (speeds, turns); -inf for pairs that do not."""
    sums = (cv2.blur(of, (3, 1), borderType=cv2.BORDER_CONSTANT) for of in (np.where(counts, score, 0.0), counts * 1.0))
    total, share = (np.asarray(one, np.float64) for one in sums)
    return np.where(counts, total / np.maximum(share, 1e-9), -math.inf)
