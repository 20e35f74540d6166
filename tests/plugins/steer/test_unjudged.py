"""Steering where cells were not judged: unknown is not free."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from graphnav_steer.mean_gradient import MeanGradient
from graphnav_steer.pca import Pca

from graphnav import Goal, Latest, Planar, Plane, Steering
from graphnav.arrays import Bytes

MakePlane = Callable[..., Plane]

ROWS, COLS = 30, 40
RIM = 5
EVERYTHING: Bytes = np.ones((ROWS, COLS), np.uint8)
BOTH = pytest.mark.parametrize("kind", [Pca, MeanGradient])


def steer(kind: type[Pca | MeanGradient], plane: Plane, **parameters: Any) -> Steering:
    stage = kind(**parameters)
    stage.reset(seed=0)
    unheard: Latest[Goal] = Latest()
    no_planar: Latest[Planar] = Latest()
    outputs = stage.step(plane, unheard, no_planar)
    return outputs if isinstance(outputs, Steering) else outputs.steering


def cleared(rows: slice, cols: slice) -> Bytes:
    """Return 1 everywhere but there."""
    cells = EVERYTHING.copy()
    cells[rows, cols] = 0
    return cells


def same(one: Steering, other: Steering) -> bool:
    return one.control.tobytes() == other.control.tobytes() and one.theta_rad == other.theta_rad


@BOTH
def test_an_unknown_cell_pushes_as_an_obstacle_does(kind: type[Pca | MeanGradient], make_plane: MakePlane) -> None:
    judged = cleared(slice(6, 20), slice(26, 34))
    unknown = steer(kind, make_plane(1 - EVERYTHING, valid=judged))
    assert same(unknown, steer(kind, make_plane(1 - judged)))
    assert unknown.theta_rad > 0
    free = steer(kind, make_plane(1 - EVERYTHING, valid=judged), unjudged="free")
    assert not free.repulsive.any()
    assert free.theta_rad == 0.0


@BOTH
def test_the_rim_does_not_push(kind: type[Pca | MeanGradient], make_plane: MakePlane) -> None:
    judged = cleared(slice(0, RIM), slice(0, COLS))
    assert not steer(kind, make_plane(1 - EVERYTHING, valid=judged)).repulsive.any()
    assert steer(kind, make_plane(1 - EVERYTHING, valid=judged), rim_ratio=0.1, backward=True).repulsive.any()


@BOTH
@pytest.mark.parametrize("seed", range(3))
def test_where_nothing_is_unknown_it_does_not_matter(
    kind: type[Pca | MeanGradient], seed: int, make_plane: MakePlane
) -> None:
    judged = 1 - EVERYTHING
    judged[2:-2, 3:-3] = 1
    obstacle = (np.random.default_rng(seed).random((ROWS, COLS)) < 0.1).astype(np.uint8) & judged
    plane = make_plane(obstacle, valid=judged)
    assert same(steer(kind, plane), steer(kind, plane, unjudged="free"))


def test_a_wall_across_the_upper_half_turns_the_robot_or_brakes_it(make_plane: MakePlane) -> None:
    steering = steer(Pca, make_plane(1 - EVERYTHING, valid=cleared(slice(0, 15), slice(0, COLS))))
    assert steering.repulsive[1] < -0.5


def test_where_nothing_was_judged_the_robot_does_not_go_on(make_plane: MakePlane) -> None:
    steering = steer(Pca, make_plane(1 - EVERYTHING, valid=1 - EVERYTHING))
    assert abs(steering.theta_rad) >= math.pi / 2


def test_unknown_cells_count_as_judged_in_the_share(make_plane: MakePlane) -> None:
    judged = cleared(slice(0, 15), slice(0, COLS))
    judged[-2:] = 0
    steering = steer(Pca, make_plane(1 - EVERYTHING, valid=judged), strength="share", gain=4.0)
    assert np.hypot(*steering.repulsive) == pytest.approx(4.0 * 15 / (ROWS - 2))
