"""Rays against a caster that tries every side with every ray."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from graphnav_world.geometry import outlines
from graphnav_world.geometry.movers import movers_of
from graphnav_world.geometry.patrol import Patrol
from graphnav_world.geometry.rays import Beams, Sides, distances_m
from graphnav_world.geometry.scene import Body

from graphnav.arrays import Doubles

FRONT = Beams(-0.75 * math.pi, 1.5 * math.pi / 719, 720)
AROUND = Beams(-math.pi, 2 * math.pi / 300, 300)


def cast_one_by_one(sides: Doubles, beams: Beams) -> Doubles:
    """Return the minimum of the distances of all pairs; a side is met from outside its body alone."""
    angles = beams.first_rad + beams.step_rad * np.arange(beams.n)
    ray, begin, along = np.stack([np.cos(angles), np.sin(angles)], 1)[:, None], sides[:, 0], sides[:, 1] - sides[:, 0]
    crossing = ray[..., 0] * along[:, 1] - ray[..., 1] * along[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        away_m = (begin[:, 0] * along[:, 1] - begin[:, 1] * along[:, 0]) / crossing
        share = (begin[:, 0] * ray[..., 1] - begin[:, 1] * ray[..., 0]) / crossing
    hit = (share >= -1e-9) & (share <= 1 + 1e-9) & (away_m > 0) & (crossing < 0)
    return np.asarray(np.where(hit, away_m, math.inf).min(axis=1))


@pytest.mark.parametrize("beams", [FRONT, AROUND])
@pytest.mark.parametrize("seed", range(12))
def test_distances_are_those_of_every_ray_with_every_side(
    seed: int, beams: Beams, random_bodies: Callable[[int], list[Body]]
) -> None:
    bodies = [body for body in random_bodies(seed) if body.course is None]
    here = np.random.default_rng(seed).uniform([-0.4, -0.9], [1.6, 0.9])
    sides = Sides(bodies, [], 0.0).at(0.0) - here
    found, expected = distances_m(sides, beams), cast_one_by_one(sides, beams)
    assert np.isfinite(found).any()
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_no_ray_slips_through_between_neighbouring_sides() -> None:
    # The rays at 0, 90, 180 and 270 degrees meet corners, and those at 45 degrees those of the box.
    room = outlines.strip(np.array([[2.0, 0], [0, 2], [-2, 0], [0, -2]]), 0.1, closed=True)
    sides = Sides([Body.wall(room, 1.0, "wall")], [], 0.2).at(0.0)
    found = distances_m(sides, Beams(-math.pi, math.pi / 180, 360))
    assert np.isfinite(found).all()
    assert found.max() == pytest.approx(2.0 - 0.05 * math.sqrt(2.0))


def test_what_is_lower_than_the_beams_is_passed_over() -> None:
    low, high = (Body.prism(outlines.box(x, 0, 0.2, 1, 0), height, "o") for x, height in ((1.0, 0.1), (2.0, 0.3)))
    sides = Sides([low, high], [], 0.2).at(0.0)
    assert distances_m(sides, Beams(0.0, 0.1, 1)) == pytest.approx([1.9])


def test_what_moves_is_where_it_is_at_the_time() -> None:
    path = Patrol(np.array([[1.0, 0.0], [3.0, 0.0]]), speed_mps=0.5)
    bodies = [Body.prism(outlines.box(0, 0, 0.2, 1, 0), 1.0, "o", path)]
    sides = Sides(bodies, movers_of([path]), 0.2)
    assert [distances_m(sides.at(t), Beams(0.0, 0.1, 1))[0] for t in (0.0, 2.0)] == pytest.approx([0.9, 1.9])


def test_nothing_is_infinitely_far() -> None:
    assert np.isposinf(distances_m(Sides([], [], 0.2).at(0.0), FRONT)).all()
