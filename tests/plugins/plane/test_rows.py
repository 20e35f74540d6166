"""The baselines that compare a cell with its image row alone."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from graphnav_plane.row_line import RowLine, row_residuals
from graphnav_plane.row_median import RowMedian, row_medians

from graphnav import Stamp

if TYPE_CHECKING:
    from tests.plugins.plane.conftest import Scenes


def test_medians_are_numpys_lower_ones_of_the_valid_values() -> None:
    rng = np.random.default_rng(0)
    values = rng.random((7, 9)).astype(np.float32)
    valid = rng.random((7, 9)) < 0.6
    valid[2] = False
    found = row_medians(values, valid)
    for row in range(7):
        kept = np.sort(values[row, valid[row]])
        assert found[row] == (kept[(len(kept) - 1) // 2] if len(kept) else 0.0)


def test_the_score_of_the_row_median_is_the_difference_from_its_length(scenes: Scenes) -> None:
    uv_px = np.zeros((30, 40, 2))
    uv_px[..., 1] = np.linspace(1.0, 4.0, 30)[:, None]
    uv_px[5, 30:] = [0.0, 3.0]
    stage = RowMedian()
    stage.reset(0)
    plane = stage.step(scenes.flow(uv_px), Stamp(0))
    expected = np.zeros((30, 40))
    expected[5, 30:] = 3.0 - uv_px[5, 0, 1]
    assert plane.score == pytest.approx(expected, abs=1e-5)
    assert np.array_equal(plane.obstacle > 0, expected > 0)


def test_the_row_median_takes_an_obstacle_across_the_picture_for_floor(scenes: Scenes) -> None:
    uv_px = scenes.floor(3.0, 0.0)
    uv_px[8:14] *= 1.5
    stage = RowMedian()
    stage.reset(0)
    assert not stage.step(scenes.flow(uv_px), Stamp(0)).obstacle.any()


@pytest.mark.parametrize("share", [0.0, 0.2, 0.4])
def test_a_line_leaves_nothing_of_straight_rows_and_all_of_the_rest(share: float) -> None:
    rng = np.random.default_rng(1)
    x = np.linspace(-1, 1, 40)
    uv_px = rng.normal(0, 2, (30, 1, 2)) + rng.normal(0, 1, (30, 1, 2)) * x[:, None]
    is_raised = rng.permuted(np.tile(np.arange(40) < round(40 * share), (30, 1)), axis=1)
    added_px = np.where(is_raised[..., None], rng.uniform(1, 3, (30, 40, 2)), 0.0)
    left_px = row_residuals(uv_px + added_px, np.ones((30, 40), np.bool_), 2, 0.05)
    assert left_px == pytest.approx(added_px, abs=1e-3)


def test_cells_that_are_not_valid_and_rows_of_three_say_nothing() -> None:
    rng = np.random.default_rng(2)
    uv_px = rng.normal(0, 1, (4, 40, 2))
    valid = np.ones((4, 40), np.bool_)
    valid[0, 3:] = valid[1] = False
    valid[2, ::2] = False
    left_px = row_residuals(np.where(valid[..., None], uv_px, 0.0), valid, 2, 0.05)
    assert not left_px[:2].any()
    assert not left_px[2, ::2].any()
    assert left_px[3].any()


@pytest.mark.parametrize("kind", [RowLine, RowMedian])
@pytest.mark.parametrize("size", [(1, 7), (2, 2), (3, 2), (30, 40)])
def test_rows_of_any_size_stay_finite(scenes: Scenes, kind: type[RowLine | RowMedian], size: tuple[int, int]) -> None:
    stage = kind()
    stage.reset(0)
    flow = scenes.flow(1e4 * scenes.floor(3.0, 0.05, *size))
    assert stage.step(flow, Stamp(0)).not_finite() is None
    some = replace(flow, valid=(np.arange(flow.valid.size) % 3 == 0).reshape(size).astype(np.uint8))
    plane = stage.step(some, Stamp(100_000))
    assert plane.not_finite() is None
    assert not plane.obstacle[some.valid == 0].any()
