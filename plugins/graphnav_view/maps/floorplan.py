"""The world from above, drawn into axes in metres."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.transforms import Transform

from graphnav import Map
from graphnav.arrays import Doubles
from graphnav_view import style

_FACES = {Map.WALL: style.WALL, Map.OBSTACLE: style.OBSTACLE, Map.MOVING: style.MOVING}


def outlines(world: Map, kind: int) -> list[Doubles]:
    """Return the outlines, (n, 2), of all bodies of one kind; of moving ones in their own frame."""
    return [world.vertices_m[world.body == body] for body in np.flatnonzero(world.kind == kind)]


def moved(outline: Doubles, pose: Doubles) -> Doubles:
    """Return an outline given in the frame of ``pose`` (x_m, y_m, yaw_rad) in the frame of the pose."""
    x, y, yaw = pose
    c, s = np.cos(yaw), np.sin(yaw)
    turned: Doubles = outline @ np.array([[c, s], [-s, c]]) + np.array([x, y])
    return turned


def bounds_m(world: Map, paths: Sequence[Doubles], moving: Doubles, margin_m: float) -> tuple[Doubles, Doubles]:
    """Return the lower left and upper right corner of the content of a world, in W.

    ``paths``: arrays (n, 2) of further points; ``moving``: poses of the moving obstacles, (n, m, 3).
    """
    points = [*paths, world.start[None, :2], world.goal_m.reshape(-1, 2)]
    points += [*outlines(world, Map.WALL), *outlines(world, Map.OBSTACLE)]
    for index, outline in enumerate(outlines(world, Map.MOVING)):
        points += [moved(outline, poses[index]) for poses in moving if index < len(poses)]
    every = np.concatenate(points)
    return every.min(axis=0) - margin_m, every.max(axis=0) + margin_m


def draw_bodies(axes: Axes, world: Map, moving: Doubles, to_axes: Transform | None = None) -> None:
    """Fill the goal region, walls and obstacles, the moving ones at their poses ``moving`` (n, 3)."""
    transform = axes.transData if to_axes is None else to_axes + axes.transData
    if len(world.goal_m):
        goal = PolyCollection(
            [world.goal_m], facecolor=style.GOAL, edgecolor=style.GOAL, alpha=0.35, zorder=1, transform=transform
        )
        axes.add_collection(goal, autolim=False)
    for kind in (Map.WALL, Map.OBSTACLE):
        _fill(axes, outlines(world, kind), kind, transform)
    _fill(axes, [moved(o, p) for o, p in zip(outlines(world, Map.MOVING), moving, strict=False)], Map.MOVING, transform)


def nearest_point(world: Map, moving: Doubles, point: Doubles) -> Doubles:
    """Return the point on any body's outline nearest to ``point`` (2,), or ``point`` itself without bodies."""
    bodies = [*outlines(world, Map.WALL), *outlines(world, Map.OBSTACLE)]
    bodies += [moved(outline, pose) for outline, pose in zip(outlines(world, Map.MOVING), moving, strict=False)]
    if not bodies:
        return point
    begin = np.concatenate(bodies)
    side = np.concatenate([np.roll(outline, -1, axis=0) for outline in bodies]) - begin
    along = ((point - begin) * side).sum(axis=1) / np.maximum((side**2).sum(axis=1), 1e-12)
    on_side: Doubles = begin + np.clip(along, 0.0, 1.0)[:, None] * side
    nearest: Doubles = on_side[np.argmin(np.hypot(*(on_side - point).T))]
    return nearest


def _fill(axes: Axes, polygons: list[Doubles], kind: int, transform: Transform) -> None:
    if polygons:
        bodies = PolyCollection(
            polygons, facecolor=_FACES[kind], edgecolor="#2b2b2b", linewidth=0.5, zorder=2, transform=transform
        )
        axes.add_collection(bodies, autolim=False)
