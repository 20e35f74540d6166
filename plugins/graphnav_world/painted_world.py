"""The faces and textures of a drawn map: they take longer to paint than all else at the start of a run."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from graphnav.arrays import Doubles
from graphnav_world.geometry.scene import Faces, faces_of
from graphnav_world.maps.map_file import MapDraw
from graphnav_world.maps.world_map import WorldMap
from graphnav_world.rendering.atlas import Atlas, floor_texels

MIN_FLOOR_M = 10.0
BEYOND_BODIES_M = 2.0


@dataclass(frozen=True)
class PaintedWorld:
    """Faces and textures of a world, whatever drives through it; they must not be changed.

    ``floor_origin_m``: the world point where the floor's texture begins.
    """

    faces: Faces
    atlas: Atlas
    floor_origin_m: Doubles


@lru_cache(maxsize=1)
def painted_world(world: WorldMap, seed: int, contrast_ratio: float, levels: int) -> PaintedWorld:
    """Return the faces of a world, and textures of which the floor's covers the map; the last one is kept.

    Variants of a study drive through the same world one after another. A world takes up to 30 MB.

    Parameters
    ----------
    world
        As `load_map` returns it: the same object for the same file and seed.
    seed
        That of the run draws the textures and where they begin on each body.
    contrast_ratio
        The contrast of all textures, times the map's.
    levels
        The number of mip levels.
    """
    draw, rng = world.draw, np.random.default_rng([seed, 0])
    faces = faces_of(draw.bodies, rng)
    low, high = _floor_m(draw)
    lack = np.maximum(MIN_FLOOR_M - (high - low), 0.0)
    textures = [draw.textures[name] for name in ("floor", *faces.textures)]
    textures = [replace(one, contrast=one.contrast * contrast_ratio) for one in textures]
    atlas = Atlas(textures, floor_texels((high - low + lack).tolist()), rng, levels)
    atlas.pixels.setflags(write=False)
    return PaintedWorld(faces, atlas, low - lack / 2)


def _floor_m(draw: MapDraw) -> tuple[Doubles, Doubles]:
    """Return the lowest and highest corner of the floor that can be seen."""
    standing = [body.outline for body in draw.bodies if body.course is None]
    points = np.concatenate([[draw.start[:2]], draw.goal_m, *standing])
    return points.min(axis=0) - BEYOND_BODIES_M, points.max(axis=0) + BEYOND_BODIES_M
