"""When stops are due, without a clock."""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphnav.live.motors.schedule import STOP_FOR_S, STOP_PERIOD_S, StopSchedule


def stops_between(schedule: StopSchedule, start_s: float, end_s: float) -> list[float]:
    """Return when stops leave if every due time is met."""
    times: list[float] = []
    while max(start_s, schedule.due_s) < end_s:
        now_s = max(start_s, schedule.due_s)
        assert schedule.take(now_s)
        times.append(now_s)
    return times


def test_before_the_first_command_nothing_is_due() -> None:
    schedule = StopSchedule(0.3)
    assert schedule.due_s == math.inf
    assert not schedule.take(1e9)


def test_silence_is_answered_for_a_second_then_once_an_age() -> None:
    schedule = StopSchedule(0.3)
    schedule.command(10.0)
    assert not schedule.take(10.29)
    times = stops_between(schedule, 10.0, 13.0)
    assert times[0] == pytest.approx(10.3)
    burst = [now_s for now_s in times if now_s < 11.29]
    assert burst == pytest.approx([10.3 + STOP_PERIOD_S * k for k in range(50)])
    rest = [now_s for now_s in times if now_s > 11.33]
    assert rest == pytest.approx([rest[0] + 0.3 * k for k in range(5)])
    assert rest[0] == pytest.approx(11.6, abs=2 * STOP_PERIOD_S)


def test_a_command_ends_the_stops_and_restarts_the_wait() -> None:
    schedule = StopSchedule(0.3)
    schedule.command(10.0)
    stops_between(schedule, 10.0, 10.5)
    schedule.command(10.5)
    assert schedule.due_s == pytest.approx(10.8)
    assert len(stops_between(schedule, 10.5, 11.49)) == 35


def test_commands_in_time_keep_stops_away() -> None:
    schedule = StopSchedule(0.3)
    for k in range(100):
        schedule.command(0.29 * k)
        assert not stops_between(schedule, 0.29 * k, 0.29 * (k + 1))


def test_an_order_is_answered_at_once_also_without_any_command() -> None:
    schedule = StopSchedule(0.3)
    schedule.order(5.0)
    times = stops_between(schedule, 5.0, 60.0)
    assert times[0] == 5.0
    assert times[-1] == pytest.approx(5.0 + STOP_FOR_S, abs=STOP_PERIOD_S)
    assert 50 <= len(times) <= 52
    assert schedule.due_s == math.inf


def test_after_an_order_silence_goes_on_being_answered() -> None:
    schedule = StopSchedule(0.3)
    schedule.command(4.9)
    schedule.order(5.0)
    times = stops_between(schedule, 5.0, 9.0)
    assert times[0] == 5.0
    assert max(b - a for a, b in itertools.pairwise(times)) == pytest.approx(0.3)


def test_missed_stops_are_not_made_up_for() -> None:
    schedule = StopSchedule(0.3)
    schedule.order(5.0)
    assert schedule.take(5.0)
    assert schedule.take(5.9)
    assert not schedule.take(5.9)


@given(
    max_age_s=st.floats(1e-4, 5.0),
    commands_s=st.lists(st.floats(0.0, 20.0), min_size=1, max_size=20).map(sorted),
)
def test_no_silence_lasts_longer_than_max_age(max_age_s: float, commands_s: list[float]) -> None:
    schedule, last_s = StopSchedule(max_age_s), commands_s[0]
    limit_s = max(max_age_s, STOP_PERIOD_S) + 1e-6
    for command_s, until_s in zip(commands_s, [*commands_s[1:], 25.0], strict=True):
        schedule.command(command_s)
        last_s = command_s
        for stop_s in stops_between(schedule, command_s, until_s):
            assert stop_s - last_s <= limit_s
            last_s = stop_s
        assert until_s - last_s <= limit_s
