"""Declared keys of a map: a world of the BARN challenge."""

from __future__ import annotations

from graphnav import Range, Record, key
from graphnav_world.maps.shape_keys import MAX_M

N_WORLDS = 300


class BarnKeys(Record):
    """One of the 300 static worlds of the BARN challenge: it brings its cylinders, the start and the goal.

    Up to 365 cylinders of 0.15 m diameter stand on a grid of 0.15 m: a field from y = 5.1 to 9.6 m, which the robot
    enters from a lane below and leaves at the top, between two rows of cylinders 4.35 m apart. It starts at (-2.25, 3)
    and looks along y; the goal is the circle of 1 m around (-2.25, 13). Beyond the field the floor is free without
    end: add a wall around the goal, as the map of the graph `barn_navigate` does.

    The worlds are those of D. Perille, A. Truong, X. Xiao and P. Stone, Benchmarking Metric Ground Navigation, SSRR
    2020; their licence is beside them.
    """

    noun = "a world of BARN"
    example = """
    barn: {}                # the world whose number the seed of the run is; from 300 on, what remains of it by 300
    barn: {world: 49}
    barn: {world: [0, 99]}  # one of these, drawn
    """

    world: Range[int] | None = key(
        None, ge=0, le=N_WORLDS - 1, doc="its number; without it the seed of the run, modulo 300"
    )
    height_m: Range[float] = key(Range(1.0, 1.0), gt=0.0, le=MAX_M, doc="of the cylinders above the floor")
    texture: str = key("obstacle", doc="of the cylinders: one of `textures`, or floor, wall or obstacle")
