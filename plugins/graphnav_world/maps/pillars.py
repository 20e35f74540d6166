"""A field of pillars, drawn: round, apart by at least a gap."""

from __future__ import annotations

import numpy as np

from graphnav.arrays import Doubles
from graphnav_world.geometry import outlines
from graphnav_world.geometry.scene import Body
from graphnav_world.maps.body_keys import Pillars
from graphnav_world.maps.draws import Draws
from graphnav_world.maps.effort import Effort

ROUNDS = 2000
TRIES = 20
PUSH = 0.9
SHAKE = 0.3
"""The share of a lack of room that a round makes up for, and the random part of it, which ends after two thirds."""
STEPS_PER_ROUND = 800
"""Of a round, beside those of each pair of pillars."""


def draw_pillars(draws: Draws, keys: Pillars) -> list[Body]:
    """Return pillars within their field, rims apart by the gap or more; none if they do not fit."""
    count, gap, height = draws.count(keys.count), draws.number(keys.gap_m), draws.number(keys.height_m)
    corner, size = draws.pair(keys.field.corner_m), draws.pair(keys.field.size_m)
    low, high = keys.radius_m.low, keys.radius_m.high
    rng = draws.rng("pillars")
    tries = (rng.uniform(low, high, count) for _ in range(TRIES))
    placed = ((spread(radii, gap, np.array(size), rng, draws.effort), radii) for radii in tries)
    places, radii = next((one for one in placed if one[0] is not None), (None, np.zeros(0)))
    if places is None:
        hint = "give a larger field, a smaller gap or fewer pillars"
        what = f"{_counted(count)} with gaps of {gap:g} m cannot be placed in the field"
        draws.wrong(keys.place("count"), what, hint)
        return []
    return [
        Body.prism(outlines.circle(x + corner[0], y + corner[1], radius), height, keys.texture)
        for (x, y), radius in zip(places, radii, strict=True)
    ]


def spread(radii: Doubles, gap_m: float, size_m: Doubles, rng: np.random.Generator, effort: Effort) -> Doubles | None:
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
        if effort.is_spent:
            break
        effort.spend(STEPS_PER_ROUND + len(radii) ** 2)
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
