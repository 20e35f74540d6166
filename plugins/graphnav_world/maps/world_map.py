"""A map of the world: one draw of a map file in which the robot fits and finds a way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path

from graphnav import Problem, UserError, shown_path
from graphnav_world.geometry.scene import Kind
from graphnav_world.maps.draws import Draws
from graphnav_world.maps.effort import Effort
from graphnav_world.maps.map_file import START_HINT, MapDraw, draw_map, extent_m
from graphnav_world.maps.map_format import MAP
from graphnav_world.maps.map_keys import MapKeys
from graphnav_world.maps.passage import Passage

ATTEMPTS = 300
LARGEST_M = 100.0
STEPS_PER_DRAW, STEPS_PER_PART = 20_000, 3000
"""Of a draw, and of each convex part of its bodies, beside the cells of its grid and its pillars."""
KEPT = 16
"""Draws that are kept: those of the maps of a study."""


@dataclass(frozen=True, eq=False)
class WorldMap:
    """A draw, and where this robot can go in it."""

    draw: MapDraw
    passage: Passage
    radius_m: float

    @cached_property
    def shortest_m(self) -> float:
        """The length of the shortest path to the goal, 0 without a goal; found for the first run that asks."""
        return self.passage.shortest_m(self.radius_m) if len(self.draw.goal_m) else 0.0


def load_map(path: Path, seed: int, robot_radius_m: float, run_seed: int | None = None) -> WorldMap:
    """Return the map that this seed draws, or, where a map's worlds are numbered, ``run_seed`` (else the seed) names.

    A map with random parts is drawn again until the robot fits at the start, a path leads to the goal and, where the
    map requires it, the straight path is blocked; at most 300 times, and no longer than its effort lasts. The same
    content, seed and radius return the same object, which must not be changed: all variants of a study drive
    through it.

    Raises
    ------
    UserError
        All problems of the file, each with its place.
    """
    return _drawn(MAP.content(path), shown_path(path), seed, robot_radius_m, run_seed)


@lru_cache(maxsize=KEPT)
def _drawn(content: bytes, source: str, seed: int, robot_radius_m: float, run_seed: int | None) -> WorldMap:
    keys, found = _read(content, source)
    problems, misfits = list(found), list[Problem]()
    effort = Effort()
    for attempt in range(ATTEMPTS if keys else 0):
        assert keys is not None
        draws = Draws(seed, attempt, effort, run_seed)
        draw = draw_map(draws, keys)
        if misfits and effort.is_spent:  # this draw may lack pillars for that alone; the one before tells what is wrong
            break
        problems += draws.problems
        if draw is None and not problems and not draws.misfits:  # the key has no value
            problems.append(Problem(keys.key_place("start"), "a map needs 'start'", START_HINT))
        if problems:
            problems += draws.misfits
            break
        effort.spend(STEPS_PER_DRAW)
        misfits = draws.misfits
        if draw and not misfits:
            largest = max(extent_m(draw))
            if largest > LARGEST_M:
                what = f"the map extends over {largest:.0f} m, but must fit into {LARGEST_M:.0f} m"
                problems = [Problem(keys.place(), what, "bring everything nearer together")]
                break
            passage = Passage(draw.bodies, draw.start, draw.goal_m)
            misfit = _misfit(draw, passage, robot_radius_m)
            if misfit is None:
                return WorldMap(draw, passage, robot_radius_m)
            effort.spend(STEPS_PER_PART * sum(len(body.parts) for body in draw.bodies) + passage.n_cells)
            misfits = [misfit]
        if not draws.drew or effort.is_spent:
            break
    raise UserError(problems or misfits)


@lru_cache(maxsize=KEPT)
def _read(content: bytes, source: str) -> tuple[MapKeys | None, Sequence[Problem]]:
    return MAP.parse(content, source)


def _misfit(draw: MapDraw, passage: Passage, radius_m: float) -> Problem | None:
    """Return what keeps the robot from driving through this draw."""
    touched = passage.touched_at_start(radius_m)
    if touched is not None:
        what = "a wall" if touched.kind == Kind.WALL else "an obstacle"
        hint = f"move it to where a robot of radius {radius_m:g} m fits"
        return Problem(draw.start_place, f"at its start the robot touches {what}", hint)
    if not len(draw.goal_m):
        return None
    needed_m = radius_m + draw.margin_m
    if not passage.leads_to_goal(needed_m):
        what = f"no path leads from the start to the goal that is {2 * needed_m:g} m wide"
        return Problem(draw.goal_place, what, "move the goal or open a gap")
    if draw.straight_blocked and not passage.straight_is_blocked(radius_m):
        what = "the straight way from the start to the goal is free, but 'passage' asks for it to be blocked"
        return Problem(draw.goal_place, what, "put an obstacle in the way")
    return None
