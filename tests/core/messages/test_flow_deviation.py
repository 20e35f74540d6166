"""How far vectors are likely to be off, asked on grids of other cells."""

from __future__ import annotations

import numpy as np
import pytest

from graphnav import FlowDeviation


def graded(rows: int, cols: int, step_px: int) -> FlowDeviation:
    """Return a deviation that is, in px, the column of its block."""
    return FlowDeviation(deviation_px=np.arange(cols, dtype=np.float32)[None].repeat(rows, axis=0), step_px=step_px)


def test_on_its_own_grid_it_is_itself() -> None:
    given = graded(30, 40, 4)
    assert given.at((30, 40), 4) is given.deviation_px


@pytest.mark.parametrize(
    ("shape", "step_px"), [((120, 160), 1), ((60, 80), 2), ((24, 32), 5), ((15, 20), 8), ((4, 5), 32)]
)
def test_on_another_grid_it_is_that_of_the_block_below_the_middle_of_each_cell(
    shape: tuple[int, int], step_px: int
) -> None:
    found = graded(30, 40, 4).at(shape, step_px)
    assert found.shape == shape
    middles_px = (np.arange(shape[1]) + 0.5) * step_px
    assert list(found[0]) == list(np.minimum(middles_px // 4, 39))


def test_cells_beyond_the_last_block_have_its_deviation() -> None:
    assert list(graded(2, 3, 4).at((1, 5), 4)[0]) == [0.0, 1.0, 2.0, 2.0, 2.0]


def test_the_share_that_is_known_is_that_inside_the_rim() -> None:
    assert graded(30, 40, 4).known_ratio(19.5, 0.17) == pytest.approx(0.5)
    assert graded(30, 40, 4).known_ratio(-1.0, 0.17) == 0.0


def test_what_is_known_well_enough_counts_in_full_and_the_rest_by_the_ratio() -> None:
    assert list(graded(1, 5, 4).sureness_at((1, 5), 4, 2.0)[0]) == pytest.approx([1.0, 1.0, 1.0, 2 / 3, 0.5])
