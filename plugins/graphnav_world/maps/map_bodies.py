"""The bodies of a map, drawn: walls, obstacles that stand, obstacles that move."""

from __future__ import annotations

import numpy as np

from graphnav.arrays import Doubles
from graphnav_world.geometry import outlines
from graphnav_world.geometry.crossing import Crossing
from graphnav_world.geometry.movers import Course
from graphnav_world.geometry.patrol import Patrol
from graphnav_world.geometry.scene import Body
from graphnav_world.maps.body_keys import Obstacle, Wall
from graphnav_world.maps.draws import Draws
from graphnav_world.maps.map_shapes import draw_line, draw_shape
from graphnav_world.maps.mover_keys import Crosses, Moves

Gap = tuple[float, float]
"""Where an opening begins and ends, in metres along the line."""


def draw_wall(draws: Draws, wall: Wall) -> list[Body]:
    """Return a wall, in parts where it has doors; none if its line cannot be one."""
    points, height_m = draw_line(draws, wall.along), draws.number(wall.height_m)
    thickness_m, min_points = draws.number(wall.thickness_m), 3 if wall.closed else 2
    if draws.is_full:
        return []
    if len(points) < min_points:
        what = f"a {'closed ' if wall.closed else ''}wall needs at least {min_points} points, not {len(points)}"
        draws.wrong(wall.place("along"), what, "add points [x, y] or an arc")
        return []
    if wall.closed and np.linalg.norm(points[-1] - points[0]) < 1e-9:
        points = points[:-1]
    if wall.closed and len(points) > 3 and outlines.crosses_itself(points):
        draws.unfit(wall.place("along"), "this closed wall crosses itself", "list its points in order around the room")
        return []
    strips = [outlines.strip(points, thickness_m, closed=wall.closed)]
    if wall.doors:
        line = np.concatenate([points, points[:1]]) if wall.closed else points
        gaps = _gaps(draws, wall, length_m(line))
        strips = [outlines.strip(part, thickness_m, closed=False) for part in cut(line, gaps)]
    if any(strip.is_folded for strip in strips):
        what = f"a wall {thickness_m:g} m thick cannot bend as sharply as this line"
        draws.unfit(wall.place("along"), what, "give a smaller thickness_m, or a wider bend")
        return []
    return [Body.wall(strip, height_m, wall.texture) for strip in strips]


def _gaps(draws: Draws, wall: Wall, end_m: float) -> list[Gap]:
    """Return where the doors of a wall of this length are."""
    gaps = []
    for door in wall.doors:
        at_m, half_m = draws.number(door.at_m), draws.number(door.width_m) / 2
        if at_m > end_m:
            what = f"this door is {at_m:.4g} m along a wall that is {end_m:.4g} m long"
            draws.unfit(door.place("at_m"), what, "give a smaller at_m")
        else:
            gaps.append((at_m - half_m, at_m + half_m))
    return gaps


def draw_obstacle(draws: Draws, obstacle: Obstacle) -> Body | None:
    """Return an obstacle, None if its shape is not one."""
    shape, height_m = draw_shape(draws, obstacle.shape), draws.number(obstacle.height_m)
    if shape is None:
        return None
    if obstacle.moves and obstacle.crosses:
        draws.wrong(obstacle.place("crosses"), "an obstacle either moves or crosses", "remove 'moves' or 'crosses'")
        return None
    course = _course(draws, obstacle, shape.center)
    outline = shape.outline - shape.center if course else shape.outline
    return Body.prism(outline, height_m, obstacle.texture, course)


def _course(draws: Draws, obstacle: Obstacle, center: Doubles) -> Course | None:
    if obstacle.crosses:
        return _crossing(draws, obstacle.crosses, center)
    return _patrol(draws, obstacle.moves, center) if obstacle.moves else None


def _patrol(draws: Draws, moves: Moves, center: Doubles) -> Patrol:
    through_m = np.array([center, *(draws.pair(point) for point in moves.through_m)])
    return Patrol(through_m, draws.number(moves.speed_mps), moves.around, draws.number(moves.ahead_m))


def _crossing(draws: Draws, crosses: Crosses, center: Doubles) -> Crossing:
    through_m = np.array([center, *(draws.pair(point) for point in crosses.through_m)])
    return Crossing(
        through_m,
        draws.number(crosses.speed_mps),
        within_m=draws.number(crosses.within_m) if crosses.within_m else None,
        within_s=draws.number(crosses.within_s) if crosses.within_s else None,
        returns=crosses.returns,
    )


def length_m(points: Doubles) -> float:
    """Return the length of a line, (n, 2)."""
    return float(_distances(points)[-1])


def cut(points: Doubles, gaps: list[Gap]) -> list[Doubles]:
    """Return the parts of a wall's line, each (n, 2), that lie outside all its doors, in order; the line is open."""
    begins = [0.0, *(end for _, end in sorted(gaps))]
    ends = [*(begin for begin, _ in sorted(gaps)), length_m(points)]
    begins = list(np.maximum.accumulate(begins))  # gaps may overlap
    return [_part(points, begin, end) for begin, end in zip(begins, ends, strict=True) if end - begin > 1e-6]


def _part(points: Doubles, begin_m: float, end_m: float) -> Doubles:
    at_m = _distances(points)
    within = at_m[(at_m > begin_m + 1e-9) & (at_m < end_m - 1e-9)]
    where = np.concatenate([[begin_m], within, [end_m]])
    return np.stack([np.interp(where, at_m, points[:, axis]) for axis in (0, 1)], axis=1)


def _distances(points: Doubles) -> Doubles:
    """Return how far along the line each point is, (n,)."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    distances: Doubles = np.concatenate([[0.0], np.cumsum(steps)])
    return distances
