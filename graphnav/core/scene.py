"""A map as a scene: areas with roles, colours and heights, described once for all that draws it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from graphnav.arrays import Doubles
from graphnav.core.messages import Map

_COLOURS = {
    "goal": "#5aa469",
    "wall": "#4c566a",
    "obstacle": "#c98a4b",
    "moving": "#8f6bb3",
    "robot": "#1d3557",
    "seen": "#2a9df4",
}
_OPACITY = {"goal": 0.4, "seen": 0.25}
_ROLES = {Map.WALL: "wall", Map.OBSTACLE: "obstacle", Map.MOVING: "moving", Map.ROBOT: "robot"}


@dataclass(frozen=True)
class SceneArea:
    """A part of a map in top view.

    ``role``: goal, wall, obstacle, moving (an obstacle that moves), robot (its body, where that is not a disc) or seen
    (what the camera sees of the floor).
    ``outline_m``: float64 (n, 2), with three vertices or more. ``height_m``: of a body, 0 for marks on the floor.
    """

    role: str
    outline_m: Doubles
    height_m: float = 0.0

    @property
    def colour(self) -> str:
        """Its colour, ``#rrggbb``."""
        return _COLOURS[self.role]

    @property
    def opacity_ratio(self) -> float:
        """How opaque it is painted: 1 for bodies."""
        return _OPACITY.get(self.role, 1.0)

    def at(self, pose: Doubles) -> SceneArea:
        """Return an area that is given in the frame of ``pose`` (x_m, y_m, yaw_rad) in the frame of the pose."""
        x, y, yaw = pose
        c, s = np.cos(yaw), np.sin(yaw)
        return SceneArea(self.role, self.outline_m @ np.array([[c, s], [-s, c]]) + np.array([x, y]), self.height_m)


class Scene:
    """The areas of a map; what has fewer than three vertices, or one that is not finite, is left out.

    ``fixed``: goal, walls, obstacles in W, in the order in which they are painted. ``moving``: moving obstacles in
    their own frames, None for one that is left out, so that poses find theirs. ``seen``: what the camera sees of the
    floor in R, None without a camera. ``robot``: its body in R, None for a disc of ``robot_radius_m``.
    """

    def __init__(self, world: Map) -> None:
        body = world.body[: len(world.vertices_m)]
        order = np.argsort(body, kind="stable")
        edges = np.searchsorted(body[order], np.arange(len(world.kind) + 1))
        outlines = [world.vertices_m[order[first:end]] for first, end in pairwise(edges.tolist())]
        heights = [*world.height_m.tolist(), *[0.0] * len(outlines)]
        bodies = [
            (role, _area(role, outline, height_m))
            for kind, outline, height_m in zip(world.kind.tolist(), outlines, heights, strict=False)
            for role in [_ROLES.get(kind, "obstacle")]
        ]
        goal = _area("goal", world.goal_m, 0.0)
        fixed = [goal, *(area for wanted in ("wall", "obstacle") for role, area in bodies if role == wanted)]
        self.fixed = tuple(area for area in fixed if area is not None)
        self.moving = tuple(area for role, area in bodies if role == "moving")
        self.robot = next((area for role, area in bodies if role == "robot"), None)
        self.seen = _area("seen", world.footprint_m, 0.0)
        self.start = world.start
        self.robot_radius_m = world.robot_radius_m

    def moving_at(self, poses: Doubles) -> list[SceneArea]:
        """Return the moving obstacles in W at their ``poses``, (n, 3), without those that have no finite pose."""
        pairs = zip(self.moving, poses, strict=False)
        return [area.at(pose) for area, pose in pairs if area is not None and np.isfinite(pose).all()]

    def seen_at(self, pose: Doubles) -> list[SceneArea]:
        """Return what the camera sees of the floor in W, empty without a camera; ``pose``: of the robot, (3,)."""
        return [] if self.seen is None else [self.seen.at(pose)]

    def bounds_m(self, paths_m: Sequence[Doubles], moving: Doubles, margin_m: float) -> tuple[Doubles, Doubles]:
        """Return the lower left and upper right corner of its content, in W.

        ``paths_m``: arrays (n, 2) of further points; ``moving``: poses of the moving obstacles, (n, m, 3).
        """
        points = [*paths_m, self.start[None, :2], *(area.outline_m for area in self.fixed)]
        points += [area.outline_m for poses in moving for area in self.moving_at(poses)]
        every = np.concatenate(points)
        return every.min(axis=0) - margin_m, every.max(axis=0) + margin_m

    def nearest_point(self, moving: Doubles, point: Doubles) -> Doubles:
        """Return the point on any body's outline nearest to ``point`` (2,), or ``point`` itself without bodies.

        ``moving``: poses of the moving obstacles, (n, 3).
        """
        bodies = [area.outline_m for area in (*self.fixed, *self.moving_at(moving)) if area.role != "goal"]
        if not bodies:
            return point
        begin = np.concatenate(bodies)
        side = np.concatenate([np.roll(outline, -1, axis=0) for outline in bodies]) - begin
        along = ((point - begin) * side).sum(axis=1) / np.maximum((side**2).sum(axis=1), 1e-12)
        on_side: Doubles = begin + np.clip(along, 0.0, 1.0)[:, None] * side
        nearest: Doubles = on_side[np.argmin(np.hypot(*(on_side - point).T))]
        return nearest


def _area(role: str, outline_m: Doubles, height_m: float) -> SceneArea | None:
    is_drawable = len(outline_m) >= 3 and np.isfinite(outline_m).all() and np.isfinite(height_m)
    return SceneArea(role, outline_m, height_m) if is_drawable else None
