"""The map, the robot and its path as entities of Rerun's 3D view."""

from __future__ import annotations

import math
from typing import Any

from graphnav.watch.export.entries.entries import Path, Pose, Robot, World
from graphnav.watch.export.entries.solids import Rgb, Solid, bodies_of, goal_of, path_of, robot_of

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
            self._stream.log(PATH, self._lines(path_of(entry)))

    def _add_world(self, entry: World) -> None:
        self._stream.log(SCENE, self._rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        for index, body in enumerate(bodies_of(entry.scene)):
            entity = f"body_{index}" if body.moving is None else f"moving_{body.moving}/body"
            self._stream.log(f"{MAP}/{entity}/sides", self._mesh(body), static=True)
            self._stream.log(f"{MAP}/{entity}/rims", self._lines(body), static=True)
        if (goal := goal_of(entry.scene)) is not None:
            self._stream.log(f"{MAP}/goal", self._lines(goal), static=True)

    def _add_robot(self, entry: Robot) -> None:
        for name, solid in zip(("outline", "seen"), robot_of(entry), strict=False):
            self._stream.log(f"{ROBOT}/{name}", self._lines(solid), static=True)

    def _lines(self, solid: Solid) -> Any:
        return self._rr.LineStrips3D(solid.lines, colors=[_bytes(solid.colour)] * len(solid.lines))

    def _mesh(self, solid: Solid) -> Any:
        assert solid.sides is not None
        vertices, triangles = solid.sides
        colours = [_bytes(solid.colour)] * len(vertices)
        return self._rr.Mesh3D(vertex_positions=vertices, triangle_indices=triangles, vertex_colors=colours)

    def _add_pose(self, entry: Pose) -> None:
        self._stream.log(ROBOT, self._transform(entry.x_m, entry.y_m, entry.yaw_rad))
        for index, (x_m, y_m, yaw_rad) in enumerate(entry.moving.reshape(-1, 3).tolist()):
            if math.isfinite(x_m + y_m + yaw_rad):
                self._stream.log(f"{MAP}/moving_{index}", self._transform(x_m, y_m, yaw_rad))

    def _transform(self, x_m: float, y_m: float, yaw_rad: float) -> Any:
        rotation = self._rr.RotationAxisAngle(axis=(0.0, 0.0, 1.0), radians=yaw_rad)
        return self._rr.Transform3D(translation=(x_m, y_m, 0.0), rotation=rotation)


def _bytes(colour: Rgb) -> tuple[int, int, int]:
    red, green, blue = (round(255 * part) for part in colour)
    return red, green, blue
