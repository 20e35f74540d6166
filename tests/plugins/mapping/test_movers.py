"""Obstacles that move are found, and searched only where something may have moved."""

from __future__ import annotations

import numpy as np
import pytest
from graphnav_mapping.movers import Look, Movers, swept
from graphnav_mapping.rolling_grid import GROUND, OBSTACLE, Box

from graphnav.arrays import Bools, Bytes

CELL_M, PERIOD_US = 0.04, 100_000
GRID, VIEW = Box(0, 0, 200, 200), Box(60, 50, 140, 150)


class CountedMovers(Movers):
    """Counts the searches."""

    n_searches = 0

    def _shift(self, cells: Bools, there: Bytes, reach: int) -> tuple[int, int]:
        self.n_searches += 1
        return super()._shift(cells, there, reach)


def look(number: int, *obstacles: Box, view: Box = VIEW, grid: Box = GRID) -> Look:
    """Return what is seen of the floor at a tick, with obstacles on it."""
    labels = np.full(view.shape, GROUND, np.uint8)
    for obstacle in obstacles:
        labels[obstacle.within(view).moved(-view.top, -view.left).cells] = OBSTACLE
    return Look(number * PERIOD_US, labels, view, grid)


@pytest.fixture
def movers() -> CountedMovers:
    return CountedMovers(0.8, 0.6, CELL_M)


def test_where_nothing_has_moved_nothing_is_searched(movers: CountedMovers) -> None:
    stands = Box(100, 90, 110, 96)
    for number in range(20):
        # The camera moves on, so that the obstacle comes into view and leaves it.
        view = VIEW.moved(3 * number - 10, 0)
        assert movers.find(look(number, stands, view=view), 0.06) == []
    assert movers.n_searches == 0


def test_what_moves_is_found_with_its_velocity(movers: CountedMovers) -> None:
    stands, goes = Box(70, 60, 76, 66), Box(100, 80, 108, 86)
    for number in range(14):
        found = movers.find(look(number, stands, goes.moved(0, number)), 0.06)
    assert movers.n_searches > 0
    (mover,) = found
    # The smallest shift that explains it may be a cell short: 7 of 8 cells in 0.8 s.
    assert (mover.rows_per_s, mover.cols_per_s) == pytest.approx((0.0, 8.75))
    assert (mover.rows.min(), mover.rows.max(), mover.cols.min(), mover.cols.max()) == (100, 107, 93, 98)


def test_what_has_left_the_view_goes_on(movers: CountedMovers) -> None:
    goes = Box(100, 120, 108, 126)
    for number in range(14):
        movers.find(look(number, goes.moved(0, number)), 0.06)
    away = VIEW.moved(0, -60)
    for number in range(14, 19):
        (mover,) = movers.find(look(number, view=away), 0.06)
    assert (mover.cols.min(), mover.cols.max()) == (137, 142)


def test_the_cells_that_are_reached(movers: CountedMovers) -> None:
    for number in range(14):
        found = movers.find(look(number, Box(100, 80, 108, 86).moved(number, 0)), 0.06)
    reached = swept(GRID, found, 1.6)
    expected = np.zeros(GRID.shape, np.uint8)
    expected[113:135, 80:86] = 1
    assert np.array_equal(reached, expected)
    part = Box(120, 70, 150, 84)
    assert np.array_equal(swept(part, found, 1.6), expected[part.cells])
