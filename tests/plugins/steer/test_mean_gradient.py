"""The mean gradient's direction in place of the principal one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from graphnav_steer.mean_gradient import MeanGradient
from graphnav_steer.pca import Pca
from graphnav_steer.potential import obstacle_field

from graphnav import Goal, Latest, Planar, Plane, Steering
from graphnav.arrays import Bytes

MakePlane = Callable[..., Plane]

ROWS, COLS = 30, 40
UNHEARD: Latest[Goal] = Latest()
NO_PLANAR: Latest[Planar] = Latest()


def steer(plane: Plane, goal: Latest[Goal] = UNHEARD, **parameters: Any) -> Steering:
    stage = MeanGradient(**parameters)
    stage.reset(seed=0)
    return stage.step(plane, goal, NO_PLANAR)


def random_map(seed: int) -> Bytes:
    rng = np.random.default_rng(seed)
    d = np.zeros((ROWS, COLS), np.uint8)
    for _ in range(3):
        row, col = rng.integers(0, ROWS - 6), rng.integers(0, COLS - 6)
        d[row : row + 6, col : col + 6] = 1
    return d


@pytest.mark.parametrize("seed", range(5))
def test_force_is_against_the_mean_gradient(make_plane: MakePlane, seed: int) -> None:
    d = random_map(seed)
    mean = obstacle_field(d.astype(np.float64), 0.5 * COLS, "zero").gradient.mean(axis=(0, 1))
    repulsive = steer(make_plane(d), bell_ratio=None, near_weight=1.0, backward=True).repulsive
    assert repulsive / np.hypot(*repulsive) == pytest.approx(-mean / np.hypot(*mean) * [1, -1])


@pytest.mark.parametrize("seed", range(5))
def test_all_but_the_direction_is_as_in_pca(make_plane: MakePlane, seed: int) -> None:
    plane, heard = make_plane(random_map(seed)), Latest(Goal(bearing_rad=0.4, distance_m=2.0), 0.0)
    parameters: dict[str, Any] = {
        "strength": "gradient",
        "gain": 9.0,
        "goal_weight": 0.5,
        "bell_ratio": 0.3,
        "near_weight": 0.5,
        "backward": True,
    }
    ours = steer(plane, heard, **parameters)
    pca = Pca(guiding="goal", **parameters)
    pca.reset(seed=0)
    theirs = pca.step(plane, heard, NO_PLANAR).steering
    assert np.allclose(ours.guiding, theirs.guiding)
    assert np.hypot(*ours.repulsive) == pytest.approx(np.hypot(*theirs.repulsive))
    isotropic = Pca(guiding="goal", isotropic_ratio=1e6, **parameters)
    isotropic.reset(seed=0)
    assert isotropic.step(plane, heard, NO_PLANAR).steering.control == pytest.approx(ours.control)


def test_obstacle_on_the_right_turns_the_robot_left(make_plane: MakePlane) -> None:
    d = np.zeros((ROWS, COLS), np.uint8)
    d[5:20, 26:38] = 1
    steering = steer(make_plane(d))
    assert steering.theta_rad > 0
    mirrored = steer(make_plane(d[:, ::-1]))
    assert mirrored.theta_rad == pytest.approx(-steering.theta_rad)
    assert mirrored.control == pytest.approx(steering.control * [-1, 1])


def test_without_an_obstacle_it_drives_to_the_beacon_or_straight_on(make_plane: MakePlane) -> None:
    nothing = make_plane(np.zeros((ROWS, COLS)))
    assert steer(nothing).theta_rad == 0.0
    assert steer(nothing, Latest(Goal(bearing_rad=-0.7, distance_m=1.0), 0.0)).theta_rad == pytest.approx(-0.7)


def test_there_are_no_eigenvalues(make_plane: MakePlane) -> None:
    assert not steer(make_plane(random_map(0))).eigenvalues.any()
