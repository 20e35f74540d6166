"""When a source or a timed stage is due."""

from __future__ import annotations

import pytest

from graphnav.core.runner.timer import Timer
from graphnav.live.clock import LiveClock


def test_fires_on_its_grid() -> None:
    timer = Timer(Timer.every(0.1), 5.0)
    due = []
    for _ in range(4):
        due.append(timer.due_s)
        assert timer.is_due(timer.due_s)
        assert not timer.is_due(timer.due_s - 0.001)
        timer.advance(timer.due_s + 0.02)
    assert due == pytest.approx([5.0, 5.1, 5.2, 5.3])
    assert timer.skipped == 0


def test_what_is_missed_is_skipped_and_counted_not_made_up_for() -> None:
    timer = Timer(Timer.every(0.1), 0.0)
    timer.advance(0.0)
    timer.advance(0.45)  # the firing of 0.1 s comes at 0.45 s: 0.4 s is still to come, 0.2 and 0.3 s are gone
    assert timer.due_s == pytest.approx(0.4)
    assert timer.skipped == 2
    timer.advance(0.45)
    assert timer.due_s == pytest.approx(0.5)
    assert timer.skipped == 2


@pytest.mark.parametrize("late_s", [0.1, 0.35, 1.0, 7.77, 1e10])
def test_however_late_the_next_firing_is_found(late_s: float) -> None:
    calls = []

    def after_s(firing: int) -> float:
        calls.append(firing)
        return firing * 0.125

    timer = Timer(after_s, 0.0)
    timer.advance(late_s)
    assert timer.due_s <= max(late_s, 0.125) < timer.due_s + 0.125
    assert timer.skipped == max(0, int(late_s / 0.125) - 1)
    assert len(calls) < 100


def test_stamps_follow_monotonic_time_whatever_happens_to_the_time_of_day() -> None:
    walls = iter([1_000_000_000_000, 0])
    clock = LiveClock(monotonic_s=lambda: 50.0, wall_ns=lambda: next(walls))
    assert clock.start_utime == 1_000_000_000
    assert clock.utime_at(51.25) == 1_001_250_000
    assert clock.now() == 1_000_000_000
