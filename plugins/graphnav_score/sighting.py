"""When a detector first sees each obstacle, and how soon the robot then reacts."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

import cv2
import numpy as np

from graphnav import Latest, Map, Metric, Plane, Role, Stage, Stamp, State, Truth, Twist, param
from graphnav.arrays import Doubles, Floats, Ints, Longs
from graphnav_score.bodies import Bodies, nearest_m
from graphnav_score.floor_points import cell_middles, floor_points_m
from graphnav_score.obstacle_history import ObstacleHistory, Seen
from graphnav_score.pixels import cell_factor

_CELL_M = 0.02
_MAX_CELLS = 4000
_MARGIN_M = 0.05
"""Points this far beside a body count as its own: a pixel's depth is that of its middle."""


class Sighting(Stage):
    """When a detector first sees each standing obstacle of the map, and how soon the robot then reacts.

    An obstacle (walls and moving bodies aside) is visible in a frame if at least ``min_cells`` cells of the plane show
    it, by the true depth of their middles. It is sighted if ``min_found_ratio`` of these are marked; cells that the
    detector did not judge are not. Distances are from the robot's rim to the nearest point of the obstacle. Obstacles
    count that were visible at some time and to which the robot came within ``near_m``.

    The robot reacts when its command turns away from the side of the obstacle, by ``min_turn_radps`` more than the
    command at the first sighting, or slows down by ``min_slowing_ratio``. Only obstacles that were within 45 degrees of
    straight ahead when sighted ask for a reaction; without ``command`` none is measured.
    """

    role: ClassVar[Role] = "score"

    metrics: ClassVar[tuple[Metric, ...]] = (
        Metric("obstacles", better="neither", bounds=(0.0, None), help="Obstacles that count."),
        Metric(
            "never_sighted_ratio",
            unit="ratio",
            better="lower",
            bounds=(0.0, 1.0),
            min_difference=0.02,
            help="Share of them that was never sighted; left out without any.",
        ),
        Metric(
            "mean_first_sighting_m",
            unit="m",
            better="higher",
            bounds=(0.0, None),
            min_difference=0.05,
            help="Distance at which an obstacle was sighted first, mean over those that were.",
        ),
        Metric(
            "min_first_sighting_m",
            unit="m",
            better="higher",
            bounds=(0.0, None),
            min_difference=0.05,
            help="Distance at which an obstacle was sighted first, minimum over those that were.",
        ),
        Metric(
            "mean_sighting_delay_m",
            unit="m",
            better="lower",
            min_difference=0.05,
            help="Distance at which an obstacle was visible first minus that at which it was sighted first, mean over "
            "those that were sighted.",
        ),
        Metric(
            "mean_time_to_react_s",
            unit="s",
            better="lower",
            bounds=(0.0, None),
            min_difference=0.1,
            help="Time from the first sighting of an obstacle ahead to the reaction to it, mean over those with one.",
        ),
        Metric(
            "reacted_ratio",
            unit="ratio",
            better="neither",
            bounds=(0.0, 1.0),
            help="Share of the obstacles sighted ahead to which the robot reacted; left out without any.",
        ),
    )

    min_cells: int = param(3, ge=1, le=1_000_000, doc="cells that show an obstacle, from which on it is visible")
    min_found_ratio: float = param(0.3, gt=0.0, le=1.0, doc="share of them marked from which on it is sighted")
    near_m: float = param(
        1.0, gt=0.0, le=100_000.0, doc="distance from the rim within which the robot comes to obstacles that count"
    )
    min_turn_radps: float = param(0.1, gt=0.0, le=1000.0, doc="change of the commanded turning rate that is a reaction")
    min_slowing_ratio: float = param(
        0.1, gt=0.0, le=1.0, doc="drop of the commanded speed that is a reaction, as a share of it"
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Forget the last drive."""
        self._map: Map | None = None
        self._histories: dict[int, ObstacleHistory] = {}

    def step(
        self,
        plane: Plane,
        truth: Truth,
        state: State,
        map: Latest[Map],  # noqa: A002  # the port's name
        command: Latest[Twist],
        stamp: Stamp,
    ) -> None:
        """Count this frame.

        Raises
        ------
        ValueError
            The plane's grid does not fit the truth.
        """
        factor = cell_factor(truth, plane.obstacle.shape, plane.step_px)
        if map.value is not None and map.value is not self._map:
            self._map, self._histories = map.value, {}
            self._bodies, self._labels = Bodies(map.value), BodyLabels(map.value)
        if self._map is None or not len(self._labels.bodies):
            return
        for history in self._histories.values():
            history.react(command.value, stamp * 1e-6, self.min_turn_radps, self.min_slowing_ratio)
        shown = self._shown(plane, truth, state, factor)
        visible, found = (np.bincount(bodies, minlength=len(self._map.kind)) for bodies in shown)
        for body, seen in self._near(state, np.flatnonzero(visible >= self.min_cells)).items():
            history = self._histories.setdefault(body, ObstacleHistory(seen.distance_m, seen.distance_m))
            history.nearest_m = min(history.nearest_m, seen.distance_m)
            if visible[body] >= self.min_cells and found[body] >= self.min_found_ratio * visible[body]:
                history.sight(seen, command.value, stamp * 1e-6)

    def summary(self) -> Mapping[str, float]:
        """Return the metrics that are defined."""
        counted = [history for history in self._histories.values() if history.nearest_m <= self.near_m]
        sighted = [(history, history.sighted) for history in counted if history.sighted is not None]
        asked = [history for history, seen in sighted if seen.is_ahead and history.command is not None]
        reactions_s = [history.reaction_s for history in asked if history.reaction_s is not None]
        values = {"obstacles": float(len(counted))}
        if counted:
            values["never_sighted_ratio"] = 1 - len(sighted) / len(counted)
        if sighted:
            distances_m = [seen.distance_m for _, seen in sighted]
            values["mean_first_sighting_m"] = float(np.mean(distances_m))
            values["min_first_sighting_m"] = min(distances_m)
            values["mean_sighting_delay_m"] = float(np.mean([h.visible_m - seen.distance_m for h, seen in sighted]))
        if reactions_s:
            values["mean_time_to_react_s"] = float(np.mean(reactions_s))
        if asked:
            values["reacted_ratio"] = len(reactions_s) / len(asked)
        return values

    def _shown(self, plane: Plane, truth: Truth, state: State, factor: int) -> tuple[Longs, Longs]:
        """Return the body that each cell shows, of those that show one, and of those of them that are marked."""
        assert self._map is not None
        points_m = floor_points_m(truth, self._map, factor)
        middles = np.ix_(*(cell_middles(size, factor) for size in truth.obstacle.shape))
        shows = truth.obstacle[middles] != 0
        if points_m is None:
            shows[:] = False
            points_m = np.zeros((*shows.shape, 2))
        c, s = math.cos(state.yaw_rad), math.sin(state.yaw_rad)
        there_m = points_m[shows] @ np.array([[c, s], [-s, c]]) + (state.x_m, state.y_m)
        bodies = self._labels.at(there_m).astype(np.int64)
        return bodies[bodies >= 0], bodies[(bodies >= 0) & (plane.obstacle[shows] != 0)]

    def _near(self, state: State, shown: Longs) -> Mapping[int, Seen]:
        """Return where the bodies are that are ``shown`` or were seen before."""
        wanted = sorted({*shown.tolist(), *self._histories})
        if not wanted:
            return {}
        assert self._map is not None
        edges = np.isin(self._bodies.body, wanted)
        ends_m, body = self._bodies.edges_m(state)[:, edges], self._bodies.body[edges]
        starts = np.flatnonzero(np.diff(body, prepend=-1))
        all_around = np.minimum(nearest_m(ends_m, 0.0, math.pi), nearest_m(ends_m, -math.pi, 0.0))
        ahead = np.minimum.reduceat(nearest_m(ends_m, -math.pi / 4, math.pi / 4), starts)
        distances = np.minimum.reduceat(all_around, starts)
        lefts = np.add.reduceat(ends_m[0, :, 1], starts)
        return {
            which: Seen(max(float(distance) - self._map.robot_radius_m, 0.0), bool(np.isfinite(near)), bool(left > 0))
            for which, distance, near, left in zip(wanted, distances, ahead, lefts, strict=True)
        }


class BodyLabels:
    """The standing obstacles of a map, drawn on a grid of 2 cm (coarser where the map is larger than 80 m).

    Attributes
    ----------
    bodies
        The indices of the standing obstacles.
    """

    def __init__(self, world: Map) -> None:
        self.bodies = np.flatnonzero(world.kind == Map.OBSTACLE)
        self._labels: Ints = np.full((1, 1), -1, np.int32)
        self._origin_m: Doubles = np.zeros(2)
        self._cell_m = _CELL_M
        outlines = [world.vertices_m[world.body == body] for body in self.bodies]
        if outlines:
            self._draw(outlines)

    def at(self, points_m: Floats) -> Ints:
        """Return the body at each of ``points_m`` (n, 2) in W, its index on the map; -1 where none stands."""
        cols, rows = ((points_m - self._origin_m) / self._cell_m).astype(np.int64).T
        inside = (rows >= 0) & (cols >= 0) & (rows < self._labels.shape[0]) & (cols < self._labels.shape[1])
        found = np.full(len(points_m), -1, np.int32)
        found[inside] = self._labels[rows[inside], cols[inside]]
        return found

    def _draw(self, outlines: list[Doubles]) -> None:
        points = np.concatenate(outlines)
        span_m = np.ptp(points, axis=0) + 4 * _MARGIN_M
        self._cell_m = max(_CELL_M, float(span_m.max()) / _MAX_CELLS)
        self._origin_m = points.min(axis=0) - 2 * _MARGIN_M
        cols, rows = np.ceil(span_m / self._cell_m).astype(int)
        self._labels = np.full((rows, cols), -1, np.int32)
        thickness = 1 + 2 * round(_MARGIN_M / self._cell_m)
        drawn = [((outline - self._origin_m) / self._cell_m).astype(np.int32) for outline in outlines]
        for body, corners in zip(self.bodies.tolist(), drawn, strict=True):
            cv2.polylines(self._labels, [corners], True, body, thickness)  # noqa: FBT003  # closed
        for body, corners in zip(self.bodies.tolist(), drawn, strict=True):
            cv2.fillPoly(self._labels, [corners], body)
