"""The beacon errs as its parameters say."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from graphnav_world.world import Pymunk

from graphnav import Goal, Latest, Stamp, Twist


def readings(maps: Path, ticks: int, seed: int = 3, **params: Any) -> list[Goal]:
    world = Pymunk(map=maps / "corridor_ccw.yaml", size=(16, 12), truth=False, **params)
    world.reset(seed)
    command = Latest(Twist(v_mps=0.0, omega_radps=0.3), 0.1)
    found = [world.step(command, Stamp(k * 100_000)).goal for k in range(ticks)]
    return [one for one in found if one is not None]


def errors_deg(maps: Path, ticks: int, seed: int = 3, **params: Any) -> list[float]:
    pairs = zip(readings(maps, ticks, seed, **params), readings(maps, ticks, seed), strict=True)
    return [math.degrees(math.remainder(one.bearing_rad - true.bearing_rad, 2 * math.pi)) for one, true in pairs]


def test_noise_is_independent_in_every_reading(maps: Path) -> None:
    errors = np.array(errors_deg(maps, 400, goal_bearing_sigma_deg=5.0))
    # 400 readings tell a standard deviation to 3.5 %, a correlation to 0.05.
    assert errors.std() == pytest.approx(5.0, rel=0.15)
    assert abs(errors.mean()) < 1.0
    assert abs(np.corrcoef(errors[1:], errors[:-1])[0, 1]) < 0.2


def test_a_bias_is_constant_and_its_sign_drawn(maps: Path) -> None:
    signs = set()
    for seed in range(6):
        errors = errors_deg(maps, 3, seed, goal_bearing_bias_deg=20.0)
        assert np.abs(errors) == pytest.approx(20.0)
        signs.add(math.copysign(1.0, errors[0]))
        assert errors == pytest.approx([errors[0]] * 3)
    assert signs == {-1.0, 1.0}


def test_a_scale_of_the_distance_leaves_the_bearing(maps: Path) -> None:
    scales = set()
    for seed in range(6):
        [true], [read] = readings(maps, 1, seed), readings(maps, 1, seed, goal_distance_ratio=0.2)
        assert read.bearing_rad == true.bearing_rad
        scales.add(round(read.distance_m / true.distance_m, 9))
    assert scales == {0.8, 1.2}


def test_bearings_stay_within_half_a_turn(maps: Path) -> None:
    found = readings(maps, 100, goal_bearing_sigma_deg=120.0, goal_bearing_bias_deg=90.0)
    assert max(abs(one.bearing_rad) for one in found) <= math.pi
