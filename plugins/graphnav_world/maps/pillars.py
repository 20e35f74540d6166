"""A field of pillars, drawn: round, apart by at least a gap."""

from __future__ import annotations

import math

import numpy as np
import yaml

from graphnav.arrays import Doubles
from graphnav_world.geometry import outlines
from graphnav_world.geometry.scene import Body
from graphnav_world.maps.map_shapes import read_height, read_texture
from graphnav_world.maps.map_text import MapText

PILLAR_HEIGHT_M = 0.5
MOST = 1000
ROUNDS = 2000
DRAWS = 20
PUSH = 0.9
SHAKE = 0.3
"""The share of a lack of room that a round makes up for, and the random part of it, which ends after two thirds."""


def read_pillars(text: MapText, node: yaml.Node, textures: tuple[str, ...]) -> list[Body]:
    """Return pillars: ``count`` of ``radius_m`` within ``field``, rims apart by ``gap_m`` or more."""
    known = ("count", "radius_m", "gap_m", "field", "height_m", "texture")
    found = text.mapping(node, "'pillars'", known, ("count", "radius_m", "gap_m", "field"))
    if not {"count", "radius_m", "gap_m", "field"} <= found.keys():
        return []
    count = text.number(found["count"], "pillars.count", least=1, whole=True)
    if count > MOST:
        text.wrong(found["count"], f"'count' is {int(count)}, but must be at most {MOST}")
        return []
    gap = text.number(found["gap_m"], "pillars.gap_m", least=0)
    field = text.mapping(found["field"], "the field", ("corner_m", "size_m"), ("corner_m", "size_m"))
    height = read_height(text, found, "pillars", PILLAR_HEIGHT_M)
    texture = read_texture(text, found, "obstacle", textures)
    least, most = text.span(found["radius_m"], "pillars.radius_m", above=0)
    if len(field) < 2 or math.isnan(count + gap + height + least + most):
        return []
    corner = text.pair(field["corner_m"], "pillars.corner_m")
    size = text.pair(field["size_m"], "pillars.size_m", above=0)
    if not np.isfinite([*corner, *size]).all():
        return []
    rng = text.rng("pillars")
    draws = (rng.uniform(least, most, int(count)) for _ in range(DRAWS))
    placed = ((spread(radii, gap, np.array(size), rng), radii) for radii in draws)
    places, radii = next((one for one in placed if one[0] is not None), (None, np.zeros(0)))
    if places is None:
        hint = "give a larger field, a smaller gap or fewer pillars"
        text.wrong(found["count"], f"{_counted(int(count))} with gaps of {gap:g} m cannot be placed in the field", hint)
        return []
    return [
        Body.prism(outlines.circle(x + corner[0], y + corner[1], radius), height, texture)
        for (x, y), radius in zip(places, radii, strict=True)
    ]


def spread(radii: Doubles, gap_m: float, size_m: Doubles, rng: np.random.Generator) -> Doubles | None:
    """Return random centres, (n, 2), of discs within [0, size] whose rims are apart by the gap; None if none is found.

    Discs that are too near push each other apart until none is; shaking, less and less, frees those that are jammed.
    """
    lows, highs = radii[:, None] * np.ones(2), size_m - radii[:, None]
    if (lows > highs).any():
        return None
    at = rng.uniform(lows, highs)
    apart = radii[:, None] + radii[None, :] + gap_m * 1.001
    np.fill_diagonal(apart, 0.0)
    for k in range(ROUNDS):
        between = at[:, None] - at[None, :]
        far = np.linalg.norm(between, axis=2)
        lack = np.maximum(apart - far, 0.0)
        if lack.max() <= gap_m * 0.001:
            return at
        push = between / np.maximum(far, 1e-9)[..., None] * lack[..., None]
        shake = SHAKE * lack.max() * max(0.0, 1 - 1.5 * k / ROUNDS)
        moved = PUSH * push.sum(axis=1) / np.maximum(1, (lack > 0).sum(axis=1))[:, None]
        at = np.clip(at + moved + rng.normal(0, shake, at.shape), lows, highs)
    return None


def _counted(count: int) -> str:
    return "1 pillar" if count == 1 else f"{count} pillars"
