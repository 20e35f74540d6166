"""The harness of the benchmarks: who is measured when, and what an interval holds."""

from __future__ import annotations

import random
from functools import partial

import pytest
from taking_turns import Ratio, results_in_turn, take_turns


def test_each_round_begins_with_another_rival() -> None:
    order: list[str] = []

    def rival(name: str) -> float:
        order.append(name)
        return 1.0

    turns = take_turns({name: partial(rival, name) for name in "abc"}, rounds=3, warm_up=0)
    assert "".join(order) == "abcbcacab"
    assert turns.costs == {name: [1.0] * 3 for name in "abc"}


def test_rounds_to_warm_up_do_not_count() -> None:
    numbers = iter(range(5))
    assert results_in_turn({"one": lambda: next(numbers)}, rounds=3, warm_up=2) == {"one": [2, 3, 4]}


@pytest.mark.parametrize(("n", "first"), [(1, 0), (5, 0), (6, 0), (9, 1), (40, 13), (2001, 956)])
def test_the_interval_is_that_of_the_sign_test(n: int, first: int) -> None:
    found = Ratio.of(random.Random(0).sample(range(n), n))
    assert (found.median, found.low, found.high) == ((n - 1) / 2, first, n - 1 - first)


def test_the_interval_holds_the_median_of_the_distribution() -> None:
    drawn = random.Random(1)
    intervals = [Ratio.of([drawn.expovariate(1.0) for _ in range(15)]) for _ in range(2000)]
    share = sum(one.low <= 0.693147 <= one.high for one in intervals) / 2000
    assert 0.95 <= share < 0.99  # ranks are integers: 0.965 of 15
