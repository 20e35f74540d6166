"""Messages of the last seconds."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from graphnav.watch.feed.channel import SECONDS, RateHistory
from graphnav.watch.spy.screen.columns import sparkline


def test_complete_seconds_are_counted_and_the_current_one_is_not() -> None:
    history = RateHistory()
    for k in range(25):
        history.add(100.0 + 0.1 * k)
    assert history.counts(102.4) == [10, 10]
    assert history.counts(103.0) == [10, 10, 5]
    assert history.counts(105.5) == [10, 10, 5, 0, 0]


def test_nothing_is_told_before_the_first_second_is_over() -> None:
    history = RateHistory()
    assert history.counts(5.0) == []
    history.add(5.0)
    assert history.counts(5.9) == []


@given(st.lists(st.floats(-1e12, 1e12) | st.sampled_from([float("nan"), float("inf")]), max_size=50))
def test_any_clock_costs_no_more_than_a_minute_of_counts(times: list[float]) -> None:
    history = RateHistory()
    for at_s in times:
        history.add(at_s)
        assert len(history.counts(at_s)) <= SECONDS
        assert sum(history.counts(at_s)) <= len(times)


@given(st.lists(st.integers(0, 10**9), max_size=80), st.integers(0, 70))
def test_bars_are_as_wide_as_asked_for_and_grow_with_the_count(counts: list[int], width: int) -> None:
    bars = sparkline(counts, width)
    assert len(bars) == width
    newest = counts[-width:] if width else []
    shown = bars[width - len(newest) :]
    for (one, bar), (other, taller) in zip(
        sorted(zip(newest, shown, strict=True)), sorted(zip(newest, shown, strict=True))[1:], strict=False
    ):
        assert one <= other
        assert bar <= taller
    if any(newest):
        assert shown[newest.index(max(newest))] == "█"
