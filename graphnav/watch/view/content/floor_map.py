"""The map of the world as JSON-compatible values: outlines in metres."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import graphnav_lcm
import numpy as np

from graphnav import Map
from graphnav.core.codec import DecodeError, decode
from graphnav.watch.feed import Received, WatchedChannel

_MAX_VERTICES = 20_000


def newest_map(channels: Iterable[WatchedChannel]) -> Received | None:
    """Return the newest map message on some channels."""
    maps = (one.newest for one in channels if one.newest and one.kind and one.kind.lcm_class is graphnav_lcm.map_t)
    return max(maps, key=lambda received: received.at_s, default=None)


def floor_map(data: bytes) -> dict[str, Any] | None:
    """Return bodies, goal, start and footprint; None if the message is not a map or too large to be drawn."""
    try:
        world = decode(Map, data)[2]
    except DecodeError:
        return None
    lengths = (len(world.vertices_m), len(world.goal_m), len(world.footprint_m), len(world.kind))
    if max(lengths) > _MAX_VERTICES or len(world.body) != len(world.vertices_m) or world.not_finite():
        return None
    edges = np.searchsorted(world.body, np.arange(len(world.kind) + 1))
    return {
        "bodies": [
            {"kind": int(kind), "outline": world.vertices_m[first:end].tolist()}
            for kind, first, end in zip(world.kind, edges[:-1], edges[1:], strict=True)
        ],
        "start": world.start.tolist(),
        "goal": world.goal_m.tolist(),
        "robot_radius_m": world.robot_radius_m,
        "footprint": world.footprint_m.tolist(),
    }
