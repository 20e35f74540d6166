"""Cells of a plane that were not judged: those of the rim, and those of which nothing is known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as nps

from graphnav import Plane
from graphnav.arrays import Bytes

ROWS, COLS = 30, 40
RIM = 5
"""Cells whose centre is nearer to the border than 0.17 times 30 cells."""


def plane(valid: Bytes) -> Plane:
    """Return a plane of ground on cells of 4 px."""
    return Plane(np.zeros_like(valid), np.zeros(valid.shape, np.float32), valid, step_px=4, obstacle_ratio=0.0)


def seen() -> Bytes:
    """Return the cells that are judged in an ordinary frame: all but a rim of irregular width."""
    valid = np.zeros((ROWS, COLS), np.uint8)
    valid[2:-2, RIM:-3] = 1
    return valid


def test_the_rim_of_an_ordinary_frame_is_not_unknown() -> None:
    assert not plane(seen()).unknown().any()
    assert plane(seen()).unknown_ratio() == 0.0


def test_a_cell_inside_without_texture_is_unknown() -> None:
    valid = seen()
    valid[14:17, 20:24] = 0
    unknown = plane(valid).unknown()
    assert unknown[14:17, 20:24].all()
    assert unknown.sum() == 12
    assert plane(valid).unknown_ratio() == pytest.approx(12 / ((ROWS - 2 * RIM) * (COLS - 2 * RIM)))


def test_a_wall_that_fills_the_upper_half_is_unknown_up_to_the_border() -> None:
    valid = seen()
    valid[:15] = 0
    unknown = plane(valid).unknown()
    assert unknown[:15].all()
    assert not unknown[15:].any()
    assert plane(valid).unknown_ratio() == pytest.approx(0.5)


def test_a_wall_counts_once_it_reaches_farther_than_the_rim() -> None:
    valid = seen()
    valid[:RIM] = 0
    assert not plane(valid).unknown().any()
    valid[: RIM + 1] = 0
    assert plane(valid).unknown()[: RIM + 1].all()
    assert plane(seen()).unknown(rim_ratio=0.0).any()


@pytest.mark.parametrize("step", [1, 2, 3])
def test_the_rim_is_as_wide_on_every_grid(step: int) -> None:
    valid = seen()
    valid[:15] = 0
    fine = np.kron(valid, np.ones((step, step), np.uint8))
    assert np.array_equal(plane(fine).unknown(1 / 6), np.kron(plane(valid).unknown(1 / 6), np.ones((step, step))) != 0)


@given(
    valid=nps.arrays(
        np.uint8, nps.array_shapes(min_dims=2, max_dims=2, min_side=0, max_side=12), elements=st.integers(0, 1)
    ),
    rim_ratio=st.floats(0.0, 0.4),
)
def test_unknown_cells_were_not_judged_and_a_wider_rim_never_adds_any_inside(valid: Bytes, rim_ratio: float) -> None:
    found = plane(valid)
    unknown = found.unknown(rim_ratio)
    assert unknown.shape == valid.shape
    assert not (unknown & (valid != 0)).any()
    assert np.array_equal(found.unknown(0.0), valid == 0)
    assert 0.0 <= found.unknown_ratio(rim_ratio) <= 1.0
    assert unknown.any() == (found.unknown_ratio(rim_ratio) > 0.0)
