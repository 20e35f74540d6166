"""Bodies on the floor as upright prisms, and their faces as flat arrays for the renderer.

A *face* is one plane polygon with one texture; it is drawn as one or more convex quads (*prims*).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import IntEnum
from functools import cached_property

import numpy as np

from graphnav.arrays import Doubles, Floats, Ints
from graphnav_world.geometry.movers import Course, Mover
from graphnav_world.geometry.outlines import Strip, convex_parts

SUN_W = np.array([0.42, 0.27, 0.87])
"""Towards the light, in W (unit length)."""
AMBIENT = 0.6


class Kind(IntEnum):
    """The kind of a body, as in `Map`."""

    WALL = 0
    OBSTACLE = 1
    MOVING = 2


@dataclass(frozen=True)
class Body:
    """An upright prism. A moving one is given in its own frame, whose origin moves along its course.

    ``parts``: convex outlines that tile it. ``sides``: the vertical faces as (from, to) pairs, (n, 2, 2), running
    counterclockwise around the body.
    """

    kind: Kind
    outline: Doubles
    parts: list[Doubles]
    sides: Doubles
    height_m: float
    texture: str
    course: Course | None = None

    @classmethod
    def prism(cls, outline: Doubles, height_m: float, texture: str, course: Course | None = None) -> Body:
        """Return an obstacle on a simple counterclockwise outline (in its own frame if it moves)."""
        sides = np.stack([outline, np.roll(outline, -1, axis=0)], axis=1)
        kind = Kind.OBSTACLE if course is None else Kind.MOVING
        return cls(kind, outline, convex_parts(outline), sides, height_m, texture, course)

    @classmethod
    def wall(cls, strip: Strip, height_m: float, texture: str) -> Body:
        """Return a wall on a strip."""
        left, right = strip.left, strip.right
        if strip.closed:
            left, right = (np.concatenate([rim, rim[:1]]) for rim in (left, right))
        sides = [np.stack([right[:-1], right[1:]], axis=1), np.stack([left[1:], left[:-1]], axis=1)[::-1]]
        if not strip.closed:
            sides += [np.array([[left[0], right[0]], [right[-1], left[-1]]])]
        return cls(Kind.WALL, strip.outline, strip.pieces, np.concatenate(sides), height_m, texture)


@dataclass(frozen=True)
class Faces:
    """All faces of a world, sides before tops within each body.

    ``quads``: float64 (prims, 4, 3), vertices counterclockwise seen from outside, in W (of moving bodies: in their
    own frame). ``face_of_prim``: int32 (prims,). ``normal``: float64 (faces, 3), outward. ``offset``: (faces,), the
    plane is normal . x = offset. ``u``, ``v``: float64 (faces, 4), texture coordinates in metres as affine functions
    of the point. ``texture``: int32 (faces,) and ``textures``, the names it points to. ``body``: int32 (faces,).
    ``shade``: float32 (faces,). ``moving``: bodies that move, and ``movers``, in the same order.
    """

    quads: Doubles
    face_of_prim: Ints
    normal: Doubles
    offset: Doubles
    u: Doubles
    v: Doubles
    texture: Ints
    textures: tuple[str, ...]
    body: Ints
    shade: Floats
    moving: tuple[int, ...] = ()
    movers: tuple[Mover, ...] = ()

    @cached_property
    def prims(self) -> Prims:
        """The constants of the prims."""
        return Prims.of(self.quads, self.body.take(self.face_of_prim), self.moving)

    @cached_property
    def of_moving(self) -> tuple[slice, ...]:
        """The faces of each moving body."""
        return slices_of(self.body, self.moving)

    def moved_by(self, movers: tuple[Mover, ...]) -> Faces:
        """Return the same faces, whose moving bodies are where these movers are."""
        is_same = all(one is other for one, other in zip(movers, self.movers, strict=True))
        return self if is_same else replace(self, movers=movers)


def shade(normal: Doubles) -> float:
    """Return the brightness of a face with this outward normal: ambient and diffuse light, 1 for the floor."""
    lambert = max(0.0, float(normal @ SUN_W))
    return (AMBIENT + (1 - AMBIENT) * lambert) / (AMBIENT + (1 - AMBIENT) * float(SUN_W[2]))


def unshaded(faces: Faces) -> Faces:
    """Return the faces, all as bright as the floor."""
    return replace(faces, shade=np.ones_like(faces.shade))


@dataclass
class _Collected:
    quads: list[Doubles] = field(default_factory=list)
    face_of_prim: list[int] = field(default_factory=list)
    normal: list[Doubles] = field(default_factory=list)
    offset: list[float] = field(default_factory=list)
    u: list[Doubles] = field(default_factory=list)
    v: list[Doubles] = field(default_factory=list)
    texture: list[str] = field(default_factory=list)
    body: list[int] = field(default_factory=list)

    def add(self, quads: Sequence[Doubles], normal: Doubles, u: Doubles, v: Doubles, body: int, texture: str) -> None:
        self.quads += quads
        self.face_of_prim += [len(self.normal)] * len(quads)
        self.normal.append(normal)
        self.offset.append(float(normal @ quads[0][0]))
        self.u.append(u)
        self.v.append(v)
        self.body.append(body)
        self.texture.append(texture)


def faces_of(bodies: Sequence[Body], rng: np.random.Generator) -> Faces:
    """Return the faces of all bodies; ``rng`` draws the texture offset of each body."""
    found = _Collected()
    for index, body in enumerate(bodies):
        start = rng.uniform(0.0, 20.0, 2)
        _add_sides(found, index, body, start)
        _add_top(found, index, body, start)
    moving = tuple(i for i, body in enumerate(bodies) if body.course is not None)
    names = tuple(dict.fromkeys(found.texture))
    normal = np.array(found.normal).reshape(-1, 3)
    return Faces(
        quads=np.array(found.quads).reshape(-1, 4, 3),
        face_of_prim=np.array(found.face_of_prim, np.int32),
        normal=normal,
        offset=np.array(found.offset),
        u=np.array(found.u).reshape(-1, 4),
        v=np.array(found.v).reshape(-1, 4),
        texture=np.array([names.index(name) for name in found.texture], np.int32),
        textures=names,
        body=np.array(found.body, np.int32),
        shade=np.array([shade(n) for n in normal], np.float32),
        moving=moving,
        movers=tuple(course for body in bodies if (course := body.course) is not None),
    )


def _add_sides(found: _Collected, index: int, body: Body, start: Doubles) -> None:
    run_m = float(start[0])
    for a, b in body.sides:
        length = math.hypot(*(b - a))
        if length == 0.0:
            continue
        along = (b - a) / length
        low, high = np.array([*a, 0.0]), np.array([*b, 0.0])
        up = np.array([0.0, 0.0, body.height_m])
        normal = np.array([along[1], -along[0], 0.0])
        u = np.array([*along, 0.0, run_m - float(along @ a)])
        v = np.array([0.0, 0.0, 1.0, start[1]])
        found.add([np.array([low, high, high + up, low + up])], normal, u, v, index, body.texture)
        run_m += length


def _add_top(found: _Collected, index: int, body: Body, start: Doubles) -> None:
    up = np.array([0.0, 0.0, 1.0])
    tops = [np.column_stack([part, np.full(len(part), body.height_m)]) for part in body.parts]
    quads = [quad for top in tops for quad in _quads(top)]
    u, v = np.array([1.0, 0.0, 0.0, start[1]]), np.array([0.0, 1.0, 0.0, start[0]])
    found.add(quads, up, u, v, index, body.texture)


def _quads(convex: Doubles) -> list[Doubles]:
    """Return a convex polygon as a fan of quads; a triangle repeats its last vertex."""
    n = len(convex)
    return [convex[[0, i, i + 1, min(i + 2, n - 1)]] for i in range(1, n - 1, 2)]


@dataclass(frozen=True)
class Prims:
    """Bounding spheres of convex quads: ``center``, float64 (3, prims), and ``radius_m``, (prims,).

    ``edges``: the lines of their edges in Pluecker coordinates, direction and moment, float64 (6, 4, prims); an edge
    without length has the line of the one before. ``of_moving``: the prims of each moving body.
    """

    center: Doubles
    radius_m: Doubles
    edges: Doubles
    of_moving: tuple[slice, ...]

    @classmethod
    def of(cls, quads: Doubles, body: Ints, moving: Sequence[int]) -> Prims:
        """Return the constants of quads, float64 (prims, 4, 3), of these bodies, ascending (prims,)."""
        center = quads.mean(axis=1)
        radius = np.linalg.norm(quads - center[:, None], axis=2).max(axis=1, initial=0.0)
        return cls(np.ascontiguousarray(center.T), radius, _edges_of(quads), slices_of(body, moving))


def _edges_of(quads: Doubles) -> Doubles:
    after = np.roll(quads, -1, axis=1)
    lines = np.concatenate([after - quads, np.cross(after, quads)], axis=2)
    has_no_length = (after == quads).all(axis=2)
    lines[has_no_length] = np.roll(lines, 1, axis=1)[has_no_length]
    return np.ascontiguousarray(lines.T)


def slices_of(body: Ints, bodies: Sequence[int]) -> tuple[slice, ...]:
    """Return what belongs to each of these bodies; ``body``: ascending."""
    return tuple(slice(*np.searchsorted(body, (one, one + 1)).tolist()) for one in bodies)
