"""The map, the robot, its path and its scans as messages for Foxglove's 3D panel."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from graphnav.arrays import Doubles, Ints
from graphnav.watch.export.entries.entries import Beams, Path, Pose, Robot, World
from graphnav.watch.export.entries.solids import Rgb, Solid, bodies_of, goal_of, path_of, robot_of

WORLD, ROBOT = "world", "robot"
"""The frame of the map, and of the robot (x forward, y left)."""
MAP_TOPIC, ROBOT_TOPIC, PATH_TOPIC, POSE_TOPIC = "/scene/map", "/scene/robot", "/scene/path", "/scene/pose"
TRANSFORM_TOPIC = "/tf"
_LINE_PX = 3.0


def scene_messages(types: Any, entry: World | Robot | Pose | Path, stamp: Any) -> Iterator[tuple[str, Any]]:
    """Yield topics and messages of an entry; ``types``: the module ``foxglove.messages``, ``stamp``: its Timestamp."""
    scene = _Scene(types, stamp)
    if isinstance(entry, World):
        yield MAP_TOPIC, scene.world(entry)
    elif isinstance(entry, Robot):
        yield ROBOT_TOPIC, scene.robot(entry)
    elif isinstance(entry, Pose):
        yield from scene.pose(entry)
    else:
        yield PATH_TOPIC, scene.path(entry)


def scan_message(types: Any, entry: Beams, stamp: Any) -> Any:
    """Return a scan in the robot's frame; ``types``: the module ``foxglove.messages``, ``stamp``: its Timestamp."""
    scan = entry.scan
    return types.LaserScan(
        timestamp=stamp,
        frame_id=ROBOT,
        pose=_Scene(types, stamp).pose_at(0.0, 0.0, 0.0),
        start_angle=scan.angle_min_rad,
        end_angle=scan.angle_min_rad + (len(scan.ranges_m) - 1) * scan.angle_increment_rad,
        ranges=scan.ranges_m.tolist(),
    )


class _Scene:
    """Makes messages with the same timestamp."""

    def __init__(self, types: Any, stamp: Any) -> None:
        self._types, self._stamp = types, stamp

    def world(self, entry: World) -> Any:
        """Return all bodies and the goal, replacing those of the previous map."""
        entities = [
            self._entity(f"body-{index}", WORLD, body)
            if body.moving is None
            else self._entity(f"moving-{body.moving}", _moving_frame(body.moving), body, is_locked=True)
            for index, body in enumerate(bodies_of(entry.scene))
        ]
        if (goal := goal_of(entry.scene)) is not None:
            entities.append(self._entity("goal", WORLD, goal))
        all_before = self._types.SceneEntityDeletion(
            timestamp=self._stamp, type=self._types.SceneEntityDeletionType.All
        )
        return self._types.SceneUpdate(deletions=[all_before], entities=entities)

    def robot(self, entry: Robot) -> Any:
        """Return the robot and its camera's view on the floor, in the robot frame."""
        entity = self._entity(ROBOT, ROBOT, *robot_of(entry), is_locked=True)
        return self._types.SceneUpdate(entities=[entity])

    def pose(self, entry: Pose) -> Iterator[tuple[str, Any]]:
        """Yield the robot's pose, and the frames of the robot and of moving obstacles."""
        yield (
            POSE_TOPIC,
            self._types.PoseInFrame(
                timestamp=self._stamp, frame_id=WORLD, pose=self.pose_at(entry.x_m, entry.y_m, entry.yaw_rad)
            ),
        )
        yield TRANSFORM_TOPIC, self._transform(ROBOT, entry.x_m, entry.y_m, entry.yaw_rad)
        for index, (x_m, y_m, yaw_rad) in enumerate(entry.moving.reshape(-1, 3).tolist()):
            if math.isfinite(x_m + y_m + yaw_rad):
                yield TRANSFORM_TOPIC, self._transform(_moving_frame(index), x_m, y_m, yaw_rad)

    def path(self, entry: Path) -> Any:
        """Return the path so far, replacing the previous one."""
        return self._types.SceneUpdate(entities=[self._entity("path", WORLD, path_of(entry))])

    def _entity(self, name: str, frame: str, *solids: Solid, is_locked: bool = False) -> Any:
        return self._types.SceneEntity(
            timestamp=self._stamp,
            frame_id=frame,
            id=name,
            frame_locked=is_locked,
            triangles=[self._triangles(*solid.sides, solid.colour) for solid in solids if solid.sides is not None],
            lines=[self._line(points, solid.colour) for solid in solids for points in solid.lines],
        )

    def _triangles(self, vertices: Doubles, triangles: Ints, colour: Rgb) -> Any:
        return self._types.TriangleListPrimitive(
            pose=self.pose_at(0.0, 0.0, 0.0),
            points=self._points(vertices),
            color=self._colour(colour, 0.6),
            indices=triangles.ravel().tolist(),
        )

    def _line(self, points: Doubles, colour: Rgb) -> Any:
        return self._types.LinePrimitive(
            type=self._types.LinePrimitiveLineType.LineStrip,
            pose=self.pose_at(0.0, 0.0, 0.0),
            thickness=_LINE_PX,
            scale_invariant=True,
            points=self._points(points),
            color=self._colour(colour, 1.0),
        )

    def _transform(self, frame: str, x_m: float, y_m: float, yaw_rad: float) -> Any:
        pose = self._pose_parts(x_m, y_m, yaw_rad)
        return self._types.FrameTransform(
            timestamp=self._stamp, parent_frame_id=WORLD, child_frame_id=frame, translation=pose[0], rotation=pose[1]
        )

    def pose_at(self, x_m: float, y_m: float, yaw_rad: float) -> Any:
        """Return a pose on the floor."""
        position, orientation = self._pose_parts(x_m, y_m, yaw_rad)
        return self._types.Pose(position=position, orientation=orientation)

    def _pose_parts(self, x_m: float, y_m: float, yaw_rad: float) -> tuple[Any, Any]:
        turn = self._types.Quaternion(x=0.0, y=0.0, z=math.sin(yaw_rad / 2), w=math.cos(yaw_rad / 2))
        return self._types.Vector3(x=x_m, y=y_m, z=0.0), turn

    def _points(self, points: Doubles) -> list[Any]:
        return [self._types.Point3(x=x, y=y, z=z) for x, y, z in points.tolist()]

    def _colour(self, rgb: Rgb, opacity: float) -> Any:
        red, green, blue = rgb
        return self._types.Color(r=red, g=green, b=blue, a=opacity)


def _moving_frame(index: int) -> str:
    return f"moving_{index}"
