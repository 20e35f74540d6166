"""The bodies of a map, drawn: walls, obstacles that stand, obstacles that move."""

from __future__ import annotations

import numpy as np

from graphnav_world.geometry import outlines
from graphnav_world.geometry.patrol import Patrol
from graphnav_world.geometry.scene import Body
from graphnav_world.maps.body_keys import Moves, Obstacle, Wall
from graphnav_world.maps.draws import Draws
from graphnav_world.maps.map_shapes import Shape, draw_line, draw_shape
from graphnav_world.maps.wall_doors import cut


def draw_wall(draws: Draws, wall: Wall) -> list[Body]:
    """Return a wall, in parts where it has doors; none if its line cannot be one."""
    points, height_m = draw_line(draws, wall.along), draws.number(wall.height_m)
    thickness_m, min_points = draws.number(wall.thickness_m), 3 if wall.closed else 2
    if len(points) < min_points:
        what = f"a {'closed ' if wall.closed else ''}wall needs at least {min_points} points, not {len(points)}"
        draws.wrong(wall.place("along"), what, "add points [x, y] or an arc")
        return []
    if wall.closed and np.linalg.norm(points[-1] - points[0]) < 1e-9:
        points = points[:-1]
    strips = [outlines.strip(points, thickness_m, closed=wall.closed)]
    if wall.doors:
        line = np.concatenate([points, points[:1]]) if wall.closed else points
        strips = [outlines.strip(part, thickness_m, closed=False) for part in cut(line, _gaps(draws, wall))]
    if any(strip.is_folded for strip in strips):
        what = f"a wall {thickness_m:g} m thick cannot bend as sharply as this line"
        draws.wrong(wall.place("along"), what, "give a smaller thickness_m, or a wider bend")
        return []
    return [Body.wall(strip, height_m, wall.texture) for strip in strips]


def _gaps(draws: Draws, wall: Wall) -> list[tuple[float, float]]:
    middles = ((draws.number(door.at_m), draws.number(door.width_m) / 2) for door in wall.doors)
    return [(at_m - half_m, at_m + half_m) for at_m, half_m in middles]


def draw_obstacle(draws: Draws, obstacle: Obstacle) -> Body | None:
    """Return an obstacle, None if its shape is not one."""
    shape, height_m = draw_shape(draws, obstacle.shape), draws.number(obstacle.height_m)
    if shape is None:
        return None
    patrol = _patrol(draws, obstacle.moves, shape) if obstacle.moves else None
    outline = shape.outline - shape.center if patrol else shape.outline
    return Body.prism(outline, height_m, obstacle.texture, patrol)


def _patrol(draws: Draws, moves: Moves, shape: Shape) -> Patrol:
    through_m = np.array([shape.center, *(draws.pair(point) for point in moves.through_m)])
    return Patrol(through_m, draws.number(moves.speed_mps), moves.around, draws.number(moves.ahead_m))
