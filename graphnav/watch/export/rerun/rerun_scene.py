"""The map, the robot and its path as entities of Rerun's 3D view."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graphnav.watch.export.entries import map_colours
from graphnav.watch.export.entries.entries import Path, Pose, Robot, World
from graphnav.watch.export.entries.map_solids import PATH_HEIGHT_M, Body, bodies_of, ring, robot_outline

SCENE, MAP, ROBOT, PATH = "scene", "scene/map", "scene/robot", "scene/path"


class RerunScene:
    """Logs maps, poses and paths to a recording stream."""

    def __init__(self, rr: Any, stream: Any) -> None:
        self._rr, self._stream = rr, stream

    def add(self, entry: World | Robot | Pose | Path) -> None:
        """Log an entry at the current time of the stream."""
        if isinstance(entry, World):
            self._add_world(entry)
        elif isinstance(entry, Robot):
            self._add_robot(entry)
        elif isinstance(entry, Pose):
            self._add_pose(entry)
        else:
            points = np.column_stack([entry.points_m, np.full(len(entry.points_m), PATH_HEIGHT_M)])
            self._stream.log(PATH, self._rr.LineStrips3D([points], colors=[_bytes(map_colours.ROBOT)]))

    def _add_world(self, entry: World) -> None:
        world = entry.world
        self._stream.log(SCENE, self._rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        n_moving = 0
        for index, body in enumerate(bodies_of(world)):
            entity = f"{MAP}/body_{index}"
            if body.kind == map_colours.MOVES:
                entity, n_moving = f"{MAP}/moving_{n_moving}/body", n_moving + 1
            self._log_body(entity, body)
        if (goal := ring(world.goal_m)) is not None:
            self._stream.log(
                f"{MAP}/goal", self._rr.LineStrips3D([goal], colors=[_bytes(map_colours.GOAL)]), static=True
            )

    def _log_body(self, entity: str, body: Body) -> None:
        colour = _bytes(map_colours.BODIES.get(body.kind, map_colours.OBSTACLE))
        corners, triangles = body.sides()
        mesh = self._rr.Mesh3D(
            vertex_positions=corners, triangle_indices=triangles, vertex_colors=[colour] * len(corners)
        )
        self._stream.log(f"{entity}/sides", mesh, static=True)
        rims = self._rr.LineStrips3D([body.ring(0.0), body.ring(body.height_m)], colors=[colour, colour])
        self._stream.log(f"{entity}/rims", rims, static=True)

    def _add_robot(self, entry: Robot) -> None:
        outline = self._rr.LineStrips3D(robot_outline(entry.radius_m), colors=[_bytes(map_colours.ROBOT)])
        self._stream.log(f"{ROBOT}/outline", outline, static=True)
        if (seen := ring(entry.footprint_m)) is not None:
            self._stream.log(
                f"{ROBOT}/seen", self._rr.LineStrips3D([seen], colors=[_bytes(map_colours.SEEN)]), static=True
            )

    def _add_pose(self, entry: Pose) -> None:
        self._stream.log(ROBOT, self._transform(entry.x_m, entry.y_m, entry.yaw_rad))
        for index, (x_m, y_m, yaw_rad) in enumerate(entry.moving.reshape(-1, 3).tolist()):
            if math.isfinite(x_m + y_m + yaw_rad):
                self._stream.log(f"{MAP}/moving_{index}", self._transform(x_m, y_m, yaw_rad))

    def _transform(self, x_m: float, y_m: float, yaw_rad: float) -> Any:
        rotation = self._rr.RotationAxisAngle(axis=(0.0, 0.0, 1.0), radians=yaw_rad)
        return self._rr.Transform3D(translation=(x_m, y_m, 0.0), rotation=rotation)


def _bytes(colour: tuple[float, float, float]) -> tuple[int, int, int]:
    red, green, blue = (round(255 * part) for part in colour)
    return red, green, blue
