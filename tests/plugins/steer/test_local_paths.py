"""Cheapest paths, and the search that goes no farther than it must, beside one over the complete grid."""

from __future__ import annotations

import heapq
import math
from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from graphnav_steer.local_paths import Floor, NearSearch, Window, cheapest_paths, connected

from graphnav.arrays import Bools, Doubles, Indices

CELL_M = 0.05
SHAPE = (60, 80)
START = (30, 40)
STEPS = [(down, right) for down in (-1, 0, 1) for right in (-1, 0, 1) if (down, right) != (0, 0)]


def step_m(price: Doubles, here: tuple[int, int], there: tuple[int, int]) -> float:
    return math.dist(here, there) * CELL_M / 2 * float(price[here] + price[there])


def costs_by_hand(passable: Bools, price: Doubles) -> Doubles:
    """Return the cost of the path to every cell by Dijkstra's algorithm, cell by cell."""
    cost_m = np.full(SHAPE, math.inf)
    cost_m[START] = 0.0
    queue = [(0.0, START)]
    while queue:
        here_m, here = heapq.heappop(queue)
        if here_m > cost_m[here]:
            continue
        for down, right in STEPS:
            there = here[0] + down, here[1] + right
            inside = 0 <= there[0] < SHAPE[0] and 0 <= there[1] < SHAPE[1]
            if inside and passable[there] and here_m + step_m(price, here, there) < cost_m[there]:
                cost_m[there] = here_m + step_m(price, here, there)
                heapq.heappush(queue, (float(cost_m[there]), there))
    return cost_m


def smooth(values: Doubles) -> Doubles:
    """Return random values as they are on a map, where neighbours are alike."""
    for axis in (0, 1):
        values = np.asarray(sum(np.roll(values, k, axis) for k in range(-3, 4)) / 7)
    return values


def drawn_map(rng: np.random.Generator) -> tuple[Bools, Doubles]:
    """Return which cells are passable, three quarters of them, and what a metre costs there."""
    noise = smooth(rng.uniform(size=SHAPE))
    passable = noise < np.quantile(noise, 0.75)
    passable[START] = True
    return passable, 1.0 + np.clip(smooth(rng.uniform(-20.0, 20.0, SHAPE)), 0.0, None)


def changed(passable: Bools, price: Doubles, rng: np.random.Generator) -> tuple[Bools, Doubles]:
    """Return a map of which a part is another one."""
    row, col = rng.integers(0, SHAPE[0] - 20), rng.integers(0, SHAPE[1] - 20)
    part = slice(row, row + 20), slice(col, col + 20)
    passable, price = passable.copy(), price.copy()
    other_passable, other_price = drawn_map(rng)
    passable[part], price[part] = other_passable[part], other_price[part]
    passable[START] = True
    return passable, price


def price_of(price: Doubles, reached: Bools, part: Window) -> Doubles:
    return np.asarray(price[part][reached[part]])


def floor_of(passable: Bools, price: Doubles) -> Floor:
    reached, window = connected(START, passable)
    return Floor(reached, window, partial(price_of, price, reached), CELL_M)


def some_ends(floor: Floor, rng: np.random.Generator, count: int) -> tuple[Indices, Doubles]:
    """Return cells that can be reached, and what each costs in addition."""
    ends = rng.permutation(np.argwhere(floor.reached))[:count]
    return ends, rng.uniform(-0.4, 3.0, len(ends))


def test_paths_cost_what_they_cost_cell_by_cell() -> None:
    passable, price = drawn_map(np.random.default_rng(1))
    found_m = cheapest_paths(START, passable, price[passable], CELL_M).cost_m
    np.testing.assert_allclose(found_m, costs_by_hand(passable, price), rtol=1e-12)


def test_a_path_goes_from_neighbour_to_neighbour_and_costs_what_is_said() -> None:
    passable, price = drawn_map(np.random.default_rng(2))
    paths = cheapest_paths(START, passable, price[passable], CELL_M)
    for row, col in np.argwhere(np.isfinite(paths.cost_m))[::97].tolist():
        path = [(int(r), int(c)) for r, c in paths.to(row, col)]
        assert path[0] == START
        assert path[-1] == (row, col)
        assert all(passable[cell] for cell in path)
        assert all(max(abs(a[0] - b[0]), abs(a[1] - b[1])) == 1 for a, b in pairwise(path))
        along_m = sum(step_m(price, a, b) for a, b in pairwise(path))
        assert along_m == pytest.approx(paths.cost_m[row, col], rel=1e-12, abs=1e-12)


def test_a_limit_changes_no_path_within_it() -> None:
    passable, price = drawn_map(np.random.default_rng(3))
    all_m = cheapest_paths(START, passable, price[passable], CELL_M).cost_m
    near_m = cheapest_paths(START, passable, price[passable], CELL_M, limit_m=1.0).cost_m
    np.testing.assert_array_equal(near_m, np.where(all_m <= 1.0, all_m, math.inf))


@pytest.mark.parametrize("count", [1, 3, 40])
@pytest.mark.parametrize("seed", [4, 5])
def test_on_a_map_that_changes_the_search_finds_what_one_from_scratch_finds(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    passable, price = drawn_map(rng)
    search = NearSearch()
    for _ in range(40):
        passable, price = changed(passable, price, rng)
        floor = floor_of(passable, price)
        ends, beyond_m = some_ends(floor, rng, count)
        best, path = search.cheapest(START, floor, ends, beyond_m)
        scratch = cheapest_paths(START, floor.reached, price[floor.reached], CELL_M)
        assert best == np.argmin(scratch.cost_m[tuple(ends.T)] + beyond_m)
        np.testing.assert_array_equal(path, scratch.to(*ends[best]))


def test_the_search_goes_no_farther_than_it_must() -> None:
    price = np.ones(SHAPE)
    looked_at = []

    def counted(part: Window) -> Doubles:
        looked_at.append(price[part].size)
        return np.asarray(price[part].reshape(-1))

    everything = slice(0, SHAPE[0]), slice(0, SHAPE[1])
    floor = Floor(np.ones(SHAPE, np.bool_), everything, counted, CELL_M)
    search = NearSearch()
    ends = np.array([(30, 44), (0, 0)])
    for _ in range(2):
        assert search.cheapest(START, floor, ends, np.zeros(2))[0] == 0
    assert looked_at[0] == price.size
    assert looked_at[1] < price.size / 10


def test_what_neighbours_connect_is_found_across_corners_only_where_they_touch() -> None:
    cells = np.array([[1, 0, 0, 0], [0, 1, 0, 1], [0, 0, 0, 1]], np.bool_)
    reached, window = connected((0, 0), cells)
    np.testing.assert_array_equal(reached, [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0]])
    assert window == (slice(0, 2), slice(0, 2))
