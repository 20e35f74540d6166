"""Draw a world from a map."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from graphnav import Place, did_you_mean
from graphnav.arrays import Doubles
from graphnav_world.geometry.scene import Body
from graphnav_world.maps.barn import draw_barn
from graphnav_world.maps.barn_moving import draw_barn_moving
from graphnav_world.maps.body_keys import Obstacle, Pillars, Wall
from graphnav_world.maps.corridor import Corridor, draw_corridor
from graphnav_world.maps.corridor_keys import BarnKeys, BarnMovingKeys, Walled
from graphnav_world.maps.draws import Draws
from graphnav_world.maps.map_bodies import draw_obstacle, draw_wall
from graphnav_world.maps.map_keys import MapKeys, PassageKeys, TextureKeys, View
from graphnav_world.maps.map_shapes import draw_shape
from graphnav_world.maps.pillars import draw_pillars
from graphnav_world.maps.ring import draw_ring
from graphnav_world.maps.zigzag import draw_zigzag
from graphnav_world.rendering.textures import Texture

TEXTURES = {
    "floor": Texture(mean=125.0, contrast=34.0, grain_m=0.16),
    "wall": Texture(mean=165.0, contrast=26.0, grain_m=0.12),
    "obstacle": Texture(mean=90.0, contrast=26.0, grain_m=0.08),
}
Pose = tuple[float, float, float]

CORRIDORS = ("corridor", "zigzag", "ring", "barn", "barn_moving")
"""Keys of a map that bring what stands and the start; a map has one of them at most."""
START_HINT = "add start: {at_m: [x, y], heading_deg: 0}"


@dataclass(frozen=True)
class MapDraw:
    """The world that one seed makes of a map.

    ``start``: x_m, y_m, yaw_rad. ``goal_m``: outline of the goal region, (n, 2), empty without one. ``textures``: by
    name; "floor" is the floor's. ``margin_m``: what a path must leave free beyond the robot's radius.
    ``straight_blocked``: whether the map asks that the straight way be blocked.
    """

    bodies: list[Body]
    start: Pose
    start_place: Place | None
    goal_m: Doubles
    goal_place: Place | None
    textures: dict[str, Texture]
    light_ratio: float
    noise_ratio: float
    margin_m: float
    straight_blocked: bool


def draw_map(draws: Draws, keys: MapKeys) -> MapDraw | None:
    """Return the world that a seed draws; None if it lacks a start. What is wrong is added to ``draws``."""
    textures = TEXTURES | {name: _texture(draws, name, one) for name, one in (keys.textures or {}).items()}
    corridor = _corridor(draws, keys)
    bodies = _bodies(draws, keys, corridor)
    _check_textures(draws, keys, textures)
    goal = draw_shape(draws, keys.goal.shape) if keys.goal else None
    start = _start(draws, keys, corridor)
    if start is None:
        return None
    given = next((name for name in CORRIDORS if getattr(keys, name)), "start")
    view, passage = keys.view or View(), keys.passage or PassageKeys()
    return MapDraw(
        bodies=bodies,
        start=start,
        start_place=keys.place("start" if keys.start else given),
        goal_m=goal.outline if goal else corridor.goal_m if corridor else np.zeros((0, 2)),
        goal_place=keys.place("goal" if keys.goal else given),
        textures=textures,
        light_ratio=draws.number(view.light_ratio),
        noise_ratio=draws.number(view.noise_ratio),
        margin_m=draws.number(passage.margin_m),
        straight_blocked=passage.straight_blocked,
    )


def extent_m(draw: MapDraw) -> tuple[float, float]:
    """Return how far a draw reaches along x and y, moving obstacles' paths included."""
    paths = [body.course.through_m for body in draw.bodies if body.course]
    points = np.concatenate([[draw.start[:2]], draw.goal_m, *(body.outline for body in draw.bodies), *paths])
    width, height = points.max(axis=0) - points.min(axis=0)
    return float(width), float(height)


def _corridor(draws: Draws, keys: MapKeys) -> Corridor | None:
    given = [name for name in CORRIDORS if getattr(keys, name)]
    if len(given) > 1:
        draws.wrong(keys.place(given[1]), f"a map has {' and '.join(map(repr, given))}", "keep one of them")
    if keys.corridor:
        return draw_corridor(draws, keys.corridor)
    if keys.zigzag:
        return draw_zigzag(draws, keys.zigzag)
    if keys.barn:
        return draw_barn(draws, keys.barn)
    if keys.barn_moving:
        return draw_barn_moving(draws, keys.barn_moving)
    return draw_ring(draws, keys.ring) if keys.ring else None


def _bodies(draws: Draws, keys: MapKeys, corridor: Corridor | None) -> list[Body]:
    walls = [body for wall in keys.walls for body in draw_wall(draws, wall)]
    obstacles = [draw_obstacle(draws, obstacle) for obstacle in keys.obstacles]
    standing = [body for body in (*(corridor.walls if corridor else ()), *walls, *obstacles) if body]
    return standing + (draw_pillars(draws, keys.pillars) if keys.pillars else [])


def _texture(draws: Draws, name: str, keys: TextureKeys) -> Texture:
    base = TEXTURES.get(name, TEXTURES["obstacle"])
    given = {"mean": keys.mean, "contrast": keys.contrast, "grain_m": keys.grain_m}
    noise = replace(base, **{key: draws.number(one) for key, one in given.items() if one})
    if keys.tile_m is None:
        return noise
    tile_m, joint_m, joint = (draws.number(one) for one in (keys.tile_m, keys.joint_m, keys.joint))
    return replace(noise, tile_m=tile_m, joint_m=joint_m, joint=joint)


def _check_textures(draws: Draws, keys: MapKeys, known: Collection[str]) -> None:
    textured: list[Wall | Obstacle | Pillars | Walled | BarnKeys | BarnMovingKeys | None] = [
        *(getattr(keys, name) for name in (*CORRIDORS, "pillars")), *keys.walls, *keys.obstacles,
    ]  # fmt: skip
    for one in textured:
        if one and one.texture not in known and not keys.written.has("textures", one.texture):
            hint = did_you_mean(one.texture, known) or f"textures are {', '.join(known)}"
            draws.wrong(one.place("texture"), f"there is no texture '{one.texture}'", hint)


def _start(draws: Draws, keys: MapKeys, corridor: Corridor | None) -> Pose | None:
    if keys.start:
        return (*draws.pair(keys.start.at_m), math.radians(draws.number(keys.start.heading_deg)))
    if not any(keys.written.has(name) for name in ("start", *CORRIDORS)):
        draws.wrong(keys.place(), "a map needs 'start'", START_HINT)
    return corridor.start if corridor else None
