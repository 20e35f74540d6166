"""Sensors are due at their rates, with a jitter that keeps the order."""

from __future__ import annotations

import numpy as np
from graphnav_world.robot import Schedule


def test_without_jitter_times_are_those_of_the_rate() -> None:
    assert Schedule(30.0).due(100_000) == [0, 33_333, 66_667, 100_000]


def test_every_time_comes_once_however_it_is_asked() -> None:
    rng = np.random.default_rng(0)
    at_once = Schedule(50.0, 0.004, (1, 2)).due(10_000_000)
    schedule, now_us, gathered = Schedule(50.0, 0.004, (1, 2)), 0, []
    while now_us < 10_000_000:
        times = schedule.due(now_us)
        assert all(time_us <= now_us for time_us in times)
        gathered += times
        now_us = min(now_us + int(rng.integers(1, 90_000)), 10_000_000)
    assert [*gathered, *schedule.due(now_us)] == at_once


def test_jitter_is_bounded_and_to_both_sides() -> None:
    times_us = np.array(Schedule(50.0, 0.004, (3,)).due(20_000_000))
    off_us = times_us - 20_000 * np.arange(len(times_us))
    assert off_us[0] == 0
    assert off_us.min() < -3_800
    assert off_us.max() > 3_800
    assert np.abs(off_us).max() <= 4_000
    assert (np.diff(times_us) > 0).all()


def test_a_seed_decides_the_jitter() -> None:
    one, same, other = (Schedule(50.0, 0.004, seed).due(1_000_000) for seed in ((1,), (1,), (2,)))
    assert one == same
    assert one != other
