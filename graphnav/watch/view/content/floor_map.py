"""The map of the world as JSON-compatible values: outlines in metres."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import graphnav_lcm

from graphnav import Map, Scene
from graphnav.core.codec import DecodeError, decode
from graphnav.watch.feed import Received, WatchedChannel

_MAX_VERTICES = 20_000


def newest_map(channels: Iterable[WatchedChannel]) -> Received | None:
    """Return the newest map message on some channels."""
    maps = (one.newest for one in channels if one.newest and one.kind and one.kind.lcm_class is graphnav_lcm.map_t)
    return max(maps, key=lambda received: received.at_s, default=None)


def floor_map(data: bytes) -> dict[str, Any] | None:
    """Return the areas of the map and the robot's radius; None if the message is not a map or too large to be drawn.

    The page draws areas in the order in which they are given: moving obstacles in their own frames, and what the camera
    sees of the floor in that of the robot.
    """
    try:
        world = decode(Map, data)[2]
    except DecodeError:
        return None
    lengths = (len(world.vertices_m), len(world.goal_m), len(world.footprint_m), len(world.kind))
    if max(lengths) > _MAX_VERTICES or len(world.body) != len(world.vertices_m) or world.not_finite():
        return None
    scene = Scene(world)
    areas = [*scene.fixed, *scene.moving, *([scene.seen] if scene.seen is not None else [])]
    return {
        "areas": [None if one is None else {"role": one.role, "outline": one.outline_m.tolist()} for one in areas],
        "robot_radius_m": scene.robot_radius_m,
    }
