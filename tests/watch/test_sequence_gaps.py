"""Losses are counted by sequence numbers, also with several writers and after restarts."""

from __future__ import annotations

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graphnav.watch.sequence_gaps import SequenceGaps


def counted(seqs: list[int]) -> tuple[int, int]:
    """Return the numbers of losses and of restarts."""
    gaps = SequenceGaps()
    for seq in seqs:
        gaps.see(seq)
    return gaps.lost, gaps.n_restarts


@pytest.mark.parametrize(
    ("seqs", "lost", "restarts"),
    [
        ([5], 0, 0),
        ([5, 6, 7], 0, 0),
        ([5, 6, 9, 10, 14], 5, 0),
        ([3, 3, 3], 0, 0),
        ([500, 501, 0, 1, 3], 1, 1),
        ([1000, 5, 1001, 6, 1002, 7], 0, 1),
        ([7, 2**62, 8, 2**62 + 1], 0, 1),
        ([-5, -4, -2], 1, 0),
        ([5, 1000, 6, 1001, 7, 1002], 0, 0),
        ([5, 1000, 2000, 6, 1001, 2001, 7, 1002, 2002], 0, 0),
        ([5, 1000, 8, 1001, 9], 2, 0),
        ([1, 3, 2, 4, 5], 0, 0),
        ([1, 3, *range(4, 13), 2, 3], 1, 1),
    ],
)
def test_what_is_missing_is_counted(seqs: list[int], lost: int, restarts: int) -> None:
    assert counted(seqs) == (lost, restarts)


def test_what_was_lost_before_a_restart_is_told_apart() -> None:
    gaps = SequenceGaps()
    for seq in (500, 503, 0, 1, 3):
        gaps.see(seq)
    assert (gaps.lost, gaps.lost_since_restart) == (3, 1)


@settings(derandomize=True, deadline=None)
@given(n=st.integers(2, 300), seed=st.integers(0, 99), share=st.floats(0, 0.9))
def test_what_was_left_out_within_is_lost(n: int, seed: int, share: float) -> None:
    rng = random.Random(seed)
    heard = [0, *(k for k in range(1, n) if rng.random() >= share), n]
    assert counted(heard) == (n + 1 - len(heard), 0)


@settings(derandomize=True, deadline=None)
@given(seqs=st.lists(st.integers(-(2**63), 2**63 - 1), min_size=1, max_size=50))
def test_any_numbers_are_taken(seqs: list[int]) -> None:
    lost, _ = counted(seqs)
    assert 0 <= lost <= 1_000_000 * len(seqs)
