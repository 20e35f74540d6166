"""The map of the world as JSON-compatible values: outlines in metres."""

from __future__ import annotations

from typing import Any

import numpy as np

from graphnav.codec import DecodeError, decode
from graphnav.messages import Map

_MAX_VERTICES = 20_000


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
