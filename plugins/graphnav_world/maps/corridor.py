"""A bent corridor, drawn from ranges: straight run-in, bend, straight run-out, closed at both ends."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import yaml

from graphnav.arrays import Doubles
from graphnav_world.geometry import outlines
from graphnav_world.geometry.scene import Body
from graphnav_world.maps.map_shapes import WALL_HEIGHT_M, WALL_THICKNESS_M, read_height, read_texture
from graphnav_world.maps.map_text import MapText

BEHIND_START_M = 0.6
BEYOND_GOAL_M = 1.0
GOAL_M = 0.5

KEYS = {
    "radius_m": 0.0,
    "half_width_m": 0.0,
    "bend_deg": 0.0,
    "run_in_m": 0.0,
    "run_out_m": 0.0,
    "start_offset_m": -math.inf,
    "start_heading_deg": -math.inf,
}
"""What a corridor is drawn from, with the bound that each number must be above."""


@dataclass(frozen=True)
class Corridor:
    """What a corridor brings to a map. ``start``: x_m, y_m, yaw_rad. ``goal_m``: an outline across the corridor."""

    walls: list[Body]
    start: tuple[float, float, float]
    goal_m: Doubles


def read_corridor(text: MapText, node: yaml.Node, textures: tuple[str, ...]) -> Corridor | None:
    """Return a corridor. The run-in begins at the origin, along x; ``radius_m`` is that of the centre line."""
    known = ("turn", *KEYS, "height_m", "thickness_m", "texture")
    found = text.mapping(node, "the corridor", known, ("turn", *KEYS))
    side = 1.0
    if "turn" in found:
        side = 1.0 if text.word(found["turn"], "'turn'", ("left", "right")) == "left" else -1.0
    values = {
        name: text.number(found[name], f"corridor.{name}", above=above) if name in found else math.nan
        for name, above in KEYS.items()
    }
    height = read_height(text, found, "corridor", WALL_HEIGHT_M)
    thickness = WALL_THICKNESS_M
    if "thickness_m" in found:
        thickness = text.number(found["thickness_m"], "corridor.thickness_m", above=0)
    texture = read_texture(text, found, "wall", textures)
    if math.isnan(sum(values.values()) + height + thickness):
        return None
    if values["half_width_m"] + thickness >= values["radius_m"]:
        text.wrong(found["half_width_m"], "the corridor is wider than its bend", "give a smaller half_width_m")
        return None
    return _build(side, values, height, thickness, texture)


def _build(side: float, values: dict[str, float], height: float, thickness: float, texture: str) -> Corridor:
    radius, half, bend = values["radius_m"], values["half_width_m"], math.radians(values["bend_deg"])
    run_in, run_out = values["run_in_m"], values["run_out_m"]
    reach = half + thickness / 2
    turn = outlines.arc((0.0, 0.0), radius, -side * math.pi / 2, side * (bend - math.pi / 2)) / radius
    out = np.array([math.cos(bend), side * math.sin(bend)])
    end = run_out + GOAL_M + BEYOND_GOAL_M

    def rim(offset: float) -> Doubles:
        """Return the line that runs at this offset to the left of the centre line."""
        bent = np.array([run_in, side * radius]) + (radius - side * offset) * turn
        first = np.array([[-BEHIND_START_M, offset]])
        return np.concatenate([first, bent, bent[-1:] + end * out])

    loop = np.concatenate([rim(-reach), rim(reach)[::-1]])
    last = rim(0.0)[-2]
    left = np.array([-out[1], out[0]])
    near, far = last + run_out * out, last + (run_out + GOAL_M) * out
    goal = np.array([near - half * left, far - half * left, far + half * left, near + half * left])
    start = (0.0, values["start_offset_m"], math.radians(values["start_heading_deg"]))
    wall = Body.wall(outlines.strip(loop, thickness, closed=True), height, texture)
    return Corridor([wall], start, goal)
