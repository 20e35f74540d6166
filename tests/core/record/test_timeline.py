"""The times of a log never decrease, whatever its stamps do."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graphnav.core.record import Timeline

DAY_US = 86_400_000_000


@pytest.mark.parametrize(
    ("utimes", "at_us", "n_jumps"),
    [
        ([], [], 0),
        ([7], [0], 0),
        ([7, 7, 9, 20], [0, 0, 2, 13], 0),
        ([0, 10, 5_000, 20, 30], [0, 10, 10, 20, 30], 1),
        ([0, 10, -(2**60), 20, 30], [0, 10, 10, 20, 30], 1),
        ([0, 10, 2**60, 20, 30], [0, 10, 10, 20, 30], 1),
        ([0, 10, 2**60], [0, 10, 10], 1),
        ([2**60, 10, 20], [0, 0, 10], 1),
        ([0, 10**15, 10**15 + 5], [0, 0, 5], 1),
        ([1000, 1100, 500, 600, 700], [0, 100, 100, 200, 300], 1),
        ([0, DAY_US, 2 * DAY_US], [0, DAY_US, 2 * DAY_US], 0),
    ],
)
def test_stamps_that_jump_take_no_time(utimes: list[int], at_us: list[int], n_jumps: int) -> None:
    timeline = Timeline(utimes)
    assert list(timeline.at_us) == at_us
    assert timeline.n_jumps == n_jumps
    assert timeline.duration_us == (at_us[-1] if at_us else 0)


@settings(derandomize=True, deadline=None)
@given(utimes=st.lists(st.integers(-(2**63), 2**63 - 1) | st.integers(0, 100), max_size=30))
def test_time_never_goes_back(utimes: list[int]) -> None:
    timeline = Timeline(utimes)
    assert len(timeline) == len(utimes)
    assert all(later >= earlier for earlier, later in itertools.pairwise(timeline.at_us))


@settings(derandomize=True, deadline=None)
@given(steps=st.lists(st.integers(0, DAY_US), min_size=1, max_size=30), begin=st.integers(0, 2**60))
def test_stamps_in_order_are_kept(steps: list[int], begin: int) -> None:
    utimes = [begin, *(begin + total for total in itertools.accumulate(steps))]
    timeline = Timeline(utimes)
    assert [begin + at_us for at_us in timeline.at_us] == utimes
    assert timeline.n_jumps == 0
