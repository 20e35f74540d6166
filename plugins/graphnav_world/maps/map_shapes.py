"""The shapes of a map: walls, obstacles, the goal region."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import yaml

from graphnav.arrays import Doubles
from graphnav_world.geometry import outlines
from graphnav_world.geometry.patrol import Patrol
from graphnav_world.geometry.scene import Body
from graphnav_world.maps.map_text import MapText, numbered

SHAPES = ("circle", "box", "polygon")
WALL_HEIGHT_M = 0.35
WALL_THICKNESS_M = 0.1


@dataclass(frozen=True)
class Shape:
    """An outline and the point that carries it when it moves."""

    outline: Doubles
    center: Doubles


def read_wall(text: MapText, node: yaml.Node, key: str, textures: tuple[str, ...]) -> Body | None:
    """Return a wall: ``along`` points and arcs, with ``height_m``, ``thickness_m``, ``closed``, ``texture``."""
    known = ("along", "height_m", "thickness_m", "closed", "texture")
    found = text.mapping(node, "a wall", known, ("along",))
    height = read_height(text, found, key, WALL_HEIGHT_M)
    thickness = WALL_THICKNESS_M
    if "thickness_m" in found:
        thickness = text.number(found["thickness_m"], f"{key}.thickness_m", above=0)
    closed = "closed" in found and text.flag(found["closed"], "closed")
    texture = read_texture(text, found, "wall", textures)
    if "along" not in found:
        return None
    points = _line(text, found["along"], f"{key}.along")
    if points is None or not math.isfinite(height * thickness):
        return None
    if len(points) < (3 if closed else 2):
        least = "a closed wall needs at least 3 points" if closed else "a wall needs at least 2 points"
        text.wrong(found["along"], f"{least}, here is {len(points)}", "add points [x, y] or an arc")
        return None
    if closed and np.linalg.norm(points[-1] - points[0]) < 1e-9:
        points = points[:-1]
    strip = outlines.strip(points, thickness, closed=closed)
    if strip.is_folded:
        hint = "give a smaller thickness_m, or a wider bend"
        text.wrong(found["along"], f"a wall {thickness:g} m thick cannot bend as sharply as this line", hint)
        return None
    return Body.wall(strip, height, texture)


def read_obstacle(text: MapText, node: yaml.Node, key: str, textures: tuple[str, ...]) -> Body | None:
    """Return an obstacle: one shape with ``height_m``, ``texture``, ``moves``."""
    others = ("height_m", "texture", "moves")
    found = _one_shape(text, node, "an obstacle", others)
    height = read_height(text, found, key, 0.5)
    texture = read_texture(text, found, "obstacle", textures)
    shape = _shape(text, found, key)
    patrol = None
    if "moves" in found:
        center = shape.center if shape else np.zeros(2)
        patrol = _patrol(text, found["moves"], f"{key}.moves", center)
    if shape is None or math.isnan(height) or ("moves" in found and patrol is None):
        return None
    outline = shape.outline if patrol is None else shape.outline - shape.center
    return Body.prism(outline, height, texture, patrol)


def read_region(text: MapText, node: yaml.Node, key: str) -> Doubles | None:
    """Return the outline of a region on the floor: one shape."""
    shape = _shape(text, _one_shape(text, node, f"the {key}", ()), key)
    return None if shape is None else shape.outline


def read_height(text: MapText, found: dict[str, yaml.Node], key: str, default_m: float) -> float:
    """Return a body's height."""
    return text.number(found["height_m"], f"{key}.height_m", above=0) if "height_m" in found else default_m


def read_texture(text: MapText, found: dict[str, yaml.Node], default: str, textures: tuple[str, ...]) -> str:
    """Return the name of a body's texture."""
    return text.word(found["texture"], "'texture'", textures) if "texture" in found else default


def _one_shape(text: MapText, node: yaml.Node, what: str, others: tuple[str, ...]) -> dict[str, yaml.Node]:
    if isinstance(node, yaml.MappingNode):
        names = [str(key.value) for key, _ in node.value]
        shapes = [name for name in names if name in SHAPES]
        strange = [(key, value) for key, value in node.value if key.value not in (*SHAPES, *others)]
        if not shapes and strange and isinstance(strange[0][1], yaml.MappingNode):
            text.wrong(strange[0][0], f"'{strange[0][0].value}' is no shape", "use circle, box or polygon")
            return {}
        if len(shapes) != 1:
            has = "no shape" if not shapes else f"{len(shapes)} shapes"
            text.wrong(node, f"{what} has {has}, but must have one", "give circle, box or polygon")
    return text.mapping(node, what, (*SHAPES, *others))


def _shape(text: MapText, found: dict[str, yaml.Node], key: str) -> Shape | None:
    for name, read in (("circle", _circle), ("box", _box), ("polygon", _polygon)):
        if name in found:
            return read(text, found[name], f"{key}.{name}")
    return None


def _circle(text: MapText, node: yaml.Node, key: str) -> Shape | None:
    found = text.mapping(node, "a circle", ("center_m", "radius_m"), ("center_m", "radius_m"))
    if len(found) < 2:
        return None
    x, y = text.pair(found["center_m"], f"{key}.center_m")
    radius = text.number(found["radius_m"], f"{key}.radius_m", above=0)
    if math.isnan(x + y + radius):
        return None
    return Shape(outlines.circle(x, y, radius), np.array([x, y]))


def _box(text: MapText, node: yaml.Node, key: str) -> Shape | None:
    found = text.mapping(node, "a box", ("center_m", "size_m", "turn_deg"), ("center_m", "size_m"))
    turn = text.number(found["turn_deg"], f"{key}.turn_deg") if "turn_deg" in found else 0.0
    if not {"center_m", "size_m"} <= found.keys():
        return None
    x, y = text.pair(found["center_m"], f"{key}.center_m")
    length, width = text.pair(found["size_m"], f"{key}.size_m", above=0)
    if math.isnan(x + y + length + width + turn):
        return None
    return Shape(outlines.box(x, y, length, width, math.radians(turn)), np.array([x, y]))


def _polygon(text: MapText, node: yaml.Node, key: str) -> Shape | None:
    found = text.mapping(node, "a polygon", ("points_m",), ("points_m",))
    if not found:
        return None
    nodes = text.items(found["points_m"], "'points_m'")
    points = np.array([text.pair(n, k) for k, n in numbered(nodes, f"{key}.points_m")]).reshape(-1, 2)
    if not np.isfinite(points).all():
        return None
    if len(points) > 3 and np.linalg.norm(points[-1] - points[0]) < 1e-9:
        points = points[:-1]
    if len(points) < 3:
        text.wrong(found["points_m"], f"a polygon of {len(points)} points is open", "give at least 3 points")
        return None
    if outlines.crosses_itself(points) or abs(outlines.signed_area(points)) < 1e-9:
        text.wrong(found["points_m"], "this polygon crosses itself or has no area", "list its corners in order")
        return None
    return Shape(outlines.counterclockwise(points), points.mean(axis=0))


def _patrol(text: MapText, node: yaml.Node, key: str, center: Doubles) -> Patrol | None:
    known = ("through_m", "speed_mps", "around", "ahead_m")
    found = text.mapping(node, "'moves'", known, ("through_m", "speed_mps"))
    if not {"through_m", "speed_mps"} <= found.keys():
        return None
    nodes = text.items(found["through_m"], "'through_m'")
    stops = [text.pair(n, k) for k, n in numbered(nodes, f"{key}.through_m")]
    speed = text.number(found["speed_mps"], f"{key}.speed_mps", least=0)
    ahead = text.number(found["ahead_m"], f"{key}.ahead_m", least=0) if "ahead_m" in found else 0.0
    around = "around" in found and text.flag(found["around"], "around")
    through = np.concatenate([center[None], np.array(stops).reshape(-1, 2)])
    if not np.isfinite(through).all() or math.isnan(speed + ahead):
        return None
    if not stops:
        text.wrong(found["through_m"], "'through_m' has no points", "give the points [x, y] that it moves to")
        return None
    return Patrol(through, speed, around, ahead)


def _line(text: MapText, node: yaml.Node, key: str) -> Doubles | None:
    """Return the points of a wall's line: each item is a point or an arc; repeated points count once."""
    runs: list[Doubles] = []
    for name, item in numbered(text.items(node, "'along'"), key):
        if isinstance(item, yaml.MappingNode):
            arc = _arc(text, item, name)
            runs += [] if arc is None else [arc]
            if arc is None:
                return None
        else:
            runs.append(np.array([text.pair(item, name)]))
    points = np.concatenate(runs) if runs else np.zeros((0, 2))
    if not np.isfinite(points).all():
        return None
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1) if len(points) else np.zeros(0)
    kept: Doubles = points[np.concatenate([[True], steps > 1e-9])] if len(points) else points
    return kept


def _arc(text: MapText, node: yaml.Node, key: str) -> Doubles | None:
    outer = text.mapping(node, "an item of 'along'", ("arc",), ("arc",))
    if not outer:
        return None
    names = ("center_m", "radius_m", "from_deg", "to_deg")
    found = text.mapping(outer["arc"], "an arc", names, names)
    if len(found) < len(names):
        return None
    x, y = text.pair(found["center_m"], f"{key}.center_m")
    radius = text.number(found["radius_m"], f"{key}.radius_m", above=0)
    start, end = (text.number(found[name], f"{key}.{name}") for name in ("from_deg", "to_deg"))
    if math.isnan(x + y + radius + start + end):
        return None
    return outlines.arc((x, y), radius, math.radians(start), math.radians(end))
