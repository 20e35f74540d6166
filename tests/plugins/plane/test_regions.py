"""Only regions that are large and strong enough are obstacle, and by default all are."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from graphnav_plane.detector import kept_regions
from graphnav_plane.residual import Residual

from graphnav import Plane, Stamp

if TYPE_CHECKING:
    from tests.plugins.plane.conftest import Scenes

SCORE = np.array(
    [
        [1.0, 0.0, 0.0, 3.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
        [0.0, 0.0, 1.0, 1.0],
    ],
    np.float32,
)


@pytest.mark.parametrize(
    ("strong_px", "min_cells", "kept"),
    [(0.5, 1, 6), (0.5, 2, 5), (0.5, 3, 3), (0.5, 4, 0), (2.0, 1, 1), (2.0, 2, 0), (1.0, 1, 1)],
)
def test_regions_count_by_area_and_by_their_strongest_cell(strong_px: float, min_cells: int, kept: int) -> None:
    assert kept_regions(SCORE > 0.5, SCORE, strong_px, min_cells).sum() == kept


def test_cells_are_connected_over_corners() -> None:
    kept = kept_regions(SCORE > 0.5, SCORE, 0.5, 2)
    assert kept[0, 0]
    assert kept[1, 1]


def test_nothing_stays_nothing() -> None:
    assert not kept_regions(np.zeros((3, 4), np.bool_), np.ones((3, 4), np.float32), 0.5, 1).any()


def judged(scenes: Scenes, **settings: float) -> Plane:
    """Return what a detector sees of a weak speck, 0.2 px, and of an obstacle whose rim is as weak."""
    scene = scenes.scene(0.0, noise_px=0.0)
    uv_px = scene.flow.uv_px.copy()
    uv_px[4, 4, 1] += 0.2
    uv_px[15:20, 15:20, 1] += 0.2
    uv_px[16:19, 16:19, 1] += 0.2
    stage = Residual(threshold_px=0.1, edge_ratio=0.0, **settings)  # type: ignore[arg-type]
    stage.reset(0)
    return stage.step(replace(scene.flow, uv_px=uv_px), scene.planar, Stamp(0))


@pytest.mark.parametrize("settings", [{"strong_ratio": 3.0}, {"min_cells": 2}])
def test_a_weak_speck_is_ground_and_the_weak_rim_of_an_obstacle_is_not(
    scenes: Scenes, settings: dict[str, float]
) -> None:
    plane, default = judged(scenes, **settings), judged(scenes)
    assert default.obstacle.sum() == 26
    assert plane.obstacle.sum() == 25
    assert not plane.obstacle[4, 4]
    assert plane.obstacle_ratio == 25 / 1200
    assert np.array_equal(plane.score, default.score)
