"""The oracle tells what the simulator knows."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from graphnav_plane.affine import Affine
from graphnav_plane.truth import Truth as Oracle

from graphnav import Truth

if TYPE_CHECKING:
    from tests.plugins.plane.conftest import Scenes


def truth(obstacle: np.ndarray, step_px: int = 1) -> Truth:
    return Truth(
        obstacle=obstacle.astype(np.uint8),
        depth_m=np.ones(obstacle.shape, np.float32),
        flow_px=np.zeros((*obstacle.shape, 2), np.float32),
        interval_us=100_000,
        step_px=step_px,
    )


def test_a_cell_is_an_obstacle_if_its_majority_is() -> None:
    obstacle = np.zeros((8, 12))
    obstacle[:, 3:] = 1
    obstacle[:, 9:] = 0
    plane = Oracle().step(truth(obstacle))
    assert plane.score == pytest.approx(np.array([[0.25, 1.0, 0.25]] * 2))
    assert np.array_equal(plane.obstacle, [[0, 1, 0]] * 2)
    assert plane.valid.all()
    assert plane.step_px == 4
    assert plane.obstacle_ratio == pytest.approx(1 / 3)


def test_cells_cut_by_the_rim_count_what_is_inside() -> None:
    plane = Oracle().step(truth(np.ones((6, 5))))
    assert np.array_equal(plane.score, np.ones((2, 2)))


def test_cells_above_the_horizon_are_not_judged() -> None:
    scene = truth(np.eye(12))
    scene.depth_m[:6] = np.inf
    plane = Oracle().step(scene)
    assert np.array_equal(plane.valid, [[0] * 3, [1] * 3, [1] * 3])


def test_a_coarser_truth_is_taken_as_it_is() -> None:
    plane = Oracle().step(truth(np.eye(4), step_px=8))
    assert plane.step_px == 8
    assert np.array_equal(plane.obstacle, np.eye(4))


def test_the_oracle_speaks_of_the_cells_of_the_detectors(scenes: Scenes) -> None:
    oracle = Oracle().step(truth(np.zeros((119, 158))))
    stage = Affine()
    stage.reset(0)
    detected = stage.step(scenes.scene().flow, scenes.stamp())
    assert (oracle.obstacle.shape, oracle.step_px) == (detected.obstacle.shape, detected.step_px)
