"""The keys of a map file."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import yaml

from graphnav import Place
from graphnav_world.corridor import Corridor, read_corridor
from graphnav_world.map_shapes import read_obstacle, read_region, read_wall
from graphnav_world.map_text import MapText, numbered
from graphnav_world.pillars import read_pillars
from graphnav_world.scene import Body
from graphnav_world.textures import Texture

Doubles = npt.NDArray[np.float64]

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
