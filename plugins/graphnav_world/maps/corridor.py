"""A bent corridor, drawn from ranges: straight run-in, bend, straight run-out, closed at both ends."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from graphnav.arrays import Doubles
from graphnav_world.geometry import outlines
from graphnav_world.geometry.scene import Body
from graphnav_world.maps.corridor_keys import CorridorKeys, RingKeys, Walled, ZigzagKeys
from graphnav_world.maps.draws import Draws

BEHIND_START_M = 0.6
BEYOND_GOAL_M = 1.0
GOAL_M = 0.5


@dataclass(frozen=True)
class Corridor:
    """Parts of a map. ``start``: x_m, y_m, yaw_rad. ``goal_m``: an outline across the corridor, empty without one.

    Worlds of BARN and of moving cylinders have those as walls, and a goal beyond them.
    """

    walls: list[Body]
    start: tuple[float, float, float]
    goal_m: Doubles


def draw_corridor(draws: Draws, keys: CorridorKeys) -> Corridor | None:
    """Return a corridor, None if it cannot be one. The run-in begins at the origin, along x."""
    radius, half, thickness = (draws.number(one) for one in (keys.radius_m, keys.half_width_m, keys.thickness_m))
    if half + thickness >= radius:
        draws.unfit(keys.place("half_width_m"), "the corridor is wider than its bend", "give a smaller half_width_m")
        return None
    side, bend = turn_sign(draws, keys), math.radians(draws.number(keys.bend_deg))
    run_in, run_out = draws.number(keys.run_in_m), draws.number(keys.run_out_m)
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
    goal = across(last + run_out * out, out, half)
    return Corridor([wall(draws, keys, loop)], start(draws, keys), goal)


def turn_sign(draws: Draws, keys: CorridorKeys | ZigzagKeys | RingKeys) -> float:
    """Return 1.0 for a turn to the left, -1.0 for one to the right, drawn where either may be."""
    if keys.turn == "either":
        return 1.0 if draws.rng(*keys.written.path, "turn").random() < 0.5 else -1.0
    return 1.0 if keys.turn == "left" else -1.0


def start(draws: Draws, keys: Walled) -> tuple[float, float, float]:
    """Return where the robot begins: x_m, y_m, yaw_rad."""
    return 0.0, draws.number(keys.start_offset_m), math.radians(draws.number(keys.start_heading_deg))


def wall(draws: Draws, keys: Walled, loop: Doubles) -> Body:
    """Return a closed wall along the points of a loop, (n, 2)."""
    strip = outlines.strip(loop, draws.number(keys.thickness_m), closed=True)
    return Body.wall(strip, draws.number(keys.height_m), keys.texture)


def across(near: Doubles, along: Doubles, half: float) -> Doubles:
    """Return the goal from a point on, (4, 2): across the corridor, along a unit vector."""
    left, far = np.array([-along[1], along[0]]), near + GOAL_M * along
    return np.array([near - half * left, far - half * left, far + half * left, near + half * left])
