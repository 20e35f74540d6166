"""The control that draws its headings."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from graphnav_steer.random import Random

from graphnav import Plane, Stamp

MakePlane = Callable[..., Plane]
FRAME_US = 100_000


def headings(plane: Plane, seed: int, frames: int = 600, **parameters: float) -> list[float]:
    stage = Random(**parameters)
    stage.reset(seed)
    return [stage.step(plane, Stamp(k * FRAME_US)).theta_rad for k in range(frames)]


def test_headings_follow_from_the_seed_alone(make_plane: MakePlane) -> None:
    free, blocked = make_plane(np.zeros((30, 40))), make_plane(np.ones((30, 40)))
    assert headings(free, seed=3) == headings(blocked, seed=3)
    assert headings(free, seed=3) != headings(free, seed=4)


def test_reset_restarts_the_same_draws(make_plane: MakePlane) -> None:
    plane, stage = make_plane(np.zeros((30, 40))), Random()
    drawn = []
    for _ in range(2):
        stage.reset(seed=5)
        drawn.append([stage.step(plane, Stamp(k * FRAME_US)).theta_rad for k in range(50)])
    assert drawn[0] == drawn[1]


def test_headings_are_held_and_reach_both_sides(make_plane: MakePlane) -> None:
    drawn = np.degrees(headings(make_plane(np.zeros((30, 40))), seed=0, frames=6000, widest_deg=60.0, hold_s=0.5))
    assert drawn.max() == pytest.approx(60, abs=1)
    assert drawn.min() == pytest.approx(-60, abs=1)
    # Exponential times of mean 0.5 s, rounded up to frames of 0.1 s, last 1 / (1 - exp(-0.2)) = 5.5 frames; 0.2 is
    # four standard errors of 1100 draws.
    changes = 1 + np.count_nonzero(np.diff(drawn))
    assert len(drawn) / changes == pytest.approx(5.5, rel=0.2)


def test_force_is_of_length_one_along_the_heading(make_plane: MakePlane) -> None:
    stage = Random()
    stage.reset(seed=1)
    steering = stage.step(make_plane(np.zeros((30, 40))), Stamp(0))
    assert not steering.repulsive.any()
    assert np.hypot(*steering.control) == pytest.approx(1.0)
    assert np.arctan2(-steering.control[0], steering.control[1]) == pytest.approx(steering.theta_rad)
