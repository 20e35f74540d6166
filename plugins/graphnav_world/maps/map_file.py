"""The keys of a map file.

Lengths are metres in W, angles degrees counterclockwise. A number may everywhere be a range ``[low, high]``, drawn
from the run's seed; so may each coordinate of a point. Everything but ``start`` may be left out, and ``start`` too
where there is a ``corridor``::

    about: one line for people
    textures:                      # gray of 255; "floor", "wall" and "obstacle" are the defaults of what they name
      floor: {mean: 125, contrast: 34, grain_m: 0.16}
      brick: {mean: [90, 120]}
    view: {light_ratio: 1, noise_ratio: 1}   # factors on the world's own parameters
    walls:
      - along: [[0, 0], [2, 0], {arc: {center_m: [2, 1], radius_m: 1, from_deg: -90, to_deg: 0}}]
        height_m: 0.35
        thickness_m: 0.1
        closed: false
        texture: brick
    obstacles:                     # each has one shape: circle, box or polygon
      - {circle: {center_m: [1, [0.4, 0.6]], radius_m: 0.2}, height_m: 0.5, texture: obstacle}
      - {box: {center_m: [3, 0], size_m: [0.4, 0.2], turn_deg: 30}}
      - {polygon: {points_m: [[4, 0], [5, 0], [4, 1]]}}
      - circle: {center_m: [1, 2], radius_m: 0.2}
        moves: {through_m: [[2, 2]], speed_mps: 0.2, around: false, ahead_m: 0}   # there and back, or around
    pillars: {count: [20, 40], radius_m: [0.1, 0.25], gap_m: 0.8, field: {corner_m: [0, 0], size_m: [8, 6]}}
    corridor:                      # brings walls, start and goal; begins at the origin, along x
      {turn: left, radius_m: 3, half_width_m: 0.7, bend_deg: 90, run_in_m: 1.5, run_out_m: 0.5,
       start_offset_m: 0, start_heading_deg: 0, height_m: 0.35, thickness_m: 0.1}
    start: {at_m: [0, 0], heading_deg: 0}
    goal: {box: {center_m: [8, 3], size_m: [1, 6]}}          # one shape
    passage: {margin_m: 0.1, straight_blocked: true}         # redraw until a path this much wider leads to the goal
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import yaml

from graphnav import Place
from graphnav.arrays import Doubles
from graphnav_world.geometry.scene import Body
from graphnav_world.maps.corridor import Corridor, read_corridor
from graphnav_world.maps.map_shapes import read_obstacle, read_region, read_wall
from graphnav_world.maps.map_text import MapText, numbered
from graphnav_world.maps.pillars import read_pillars
from graphnav_world.rendering.textures import Texture

KEYS = ("about", "textures", "view", "corridor", "walls", "obstacles", "pillars", "start", "goal", "passage")
TEXTURES = {
    "floor": Texture(mean=125.0, contrast=34.0, grain_m=0.16),
    "wall": Texture(mean=165.0, contrast=26.0, grain_m=0.12),
    "obstacle": Texture(mean=90.0, contrast=26.0, grain_m=0.08),
}


@dataclass(frozen=True)
class MapDraw:
    """What one seed makes of a map file.

    ``start``: x_m, y_m, yaw_rad. ``goal_m``: outline of the goal region, (n, 2), empty without one. ``textures``: by
    name; "floor" is the floor's. ``margin_m``: what a path must leave free beyond the robot's radius.
    ``straight_blocked``: whether the map asks that the straight way be blocked.
    """

    bodies: list[Body]
    start: tuple[float, float, float]
    start_place: Place
    goal_m: Doubles
    goal_place: Place
    textures: dict[str, Texture]
    light_ratio: float
    noise_ratio: float
    margin_m: float
    straight_blocked: bool


def read_map(text: MapText, root: yaml.Node) -> MapDraw | None:
    """Return what the file says; None if it lacks a start. What is wrong is noted in ``text``."""
    found = text.mapping(root, "a map", KEYS)
    textures = TEXTURES | (_textures(text, found["textures"]) if "textures" in found else {})
    names = tuple(textures)
    corridor = read_corridor(text, found["corridor"], names) if "corridor" in found else None
    bodies = _bodies(text, found, corridor, names)
    goal = read_region(text, found["goal"], "goal") if "goal" in found else None
    if goal is None:
        goal = corridor.goal_m if corridor else np.zeros((0, 2))
    view = text.mapping(found["view"], "'view'", ("light_ratio", "noise_ratio")) if "view" in found else {}
    light, noise = (
        text.number(view[name], f"view.{name}", least=0) if name in view else 1.0
        for name in ("light_ratio", "noise_ratio")
    )
    margin, blocked = _passage(text, found["passage"]) if "passage" in found else (0.0, False)
    start = _start(text, root, found, corridor)
    if start is None:
        return None
    start_place, goal_place = (text.place(found.get(key, found.get("corridor"))) for key in ("start", "goal"))
    return MapDraw(bodies, start, start_place, goal, goal_place, textures, light, noise, margin, blocked)


def extent_m(draw: MapDraw) -> tuple[float, float]:
    """Return how far a draw reaches along x and y, moving obstacles' paths included."""
    paths = [body.patrol.through_m for body in draw.bodies if body.patrol]
    points = np.concatenate([[draw.start[:2]], draw.goal_m, *(body.outline for body in draw.bodies), *paths])
    width, height = points.max(axis=0) - points.min(axis=0)
    return float(width), float(height)


def _bodies(
    text: MapText, found: dict[str, yaml.Node], corridor: Corridor | None, names: tuple[str, ...]
) -> list[Body]:
    bodies = list(corridor.walls) if corridor else []
    for key, read in (("walls", read_wall), ("obstacles", read_obstacle)):
        if key in found:
            made = [read(text, n, k, names) for k, n in numbered(text.items(found[key], f"'{key}'"), key)]
            bodies += [body for body in made if body is not None]
    return bodies + (read_pillars(text, found["pillars"], names) if "pillars" in found else [])


def _textures(text: MapText, node: yaml.Node) -> dict[str, Texture]:
    read = {}
    for name, value in text.entries(node, "'textures'").items():
        keys = {"mean": 0.0, "contrast": 0.0, "grain_m": 0.0}
        found = text.mapping(value, f"texture '{name}'", keys)
        numbers = {key: text.number(one, f"textures.{name}.{key}", above=0.0) for key, one in found.items()}
        if not any(math.isnan(number) for number in numbers.values()):
            base = TEXTURES.get(name, TEXTURES["obstacle"])
            whole = {key: numbers.get(key, getattr(base, key)) for key in keys}
            read[name] = Texture(**whole)
        else:
            read[name] = TEXTURES["obstacle"]
    return read


def _start(
    text: MapText, root: yaml.Node, found: dict[str, yaml.Node], corridor: Corridor | None
) -> tuple[float, float, float] | None:
    if "start" not in found:
        if corridor is None and "corridor" not in found and isinstance(root, yaml.MappingNode):
            text.wrong(root, "a map needs 'start'", "add start: {at_m: [x, y], heading_deg: 0}")
        return corridor.start if corridor else None
    start = text.mapping(found["start"], "the start", ("at_m", "heading_deg"), ("at_m",))
    heading = text.number(start["heading_deg"], "start.heading_deg") if "heading_deg" in start else 0.0
    x, y = text.pair(start["at_m"], "start.at_m") if "at_m" in start else (math.nan, math.nan)
    return None if math.isnan(x + y + heading) else (x, y, math.radians(heading))


def _passage(text: MapText, node: yaml.Node) -> tuple[float, bool]:
    found = text.mapping(node, "'passage'", ("margin_m", "straight_blocked"))
    margin = text.number(found["margin_m"], "passage.margin_m", least=0) if "margin_m" in found else 0.0
    return margin, "straight_blocked" in found and text.flag(found["straight_blocked"], "straight_blocked")
