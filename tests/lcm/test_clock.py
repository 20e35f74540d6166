"""Simulated time passes at the pace that is asked for."""

from __future__ import annotations

from graphnav.core.runner.simulated_clock import SimulatedClock


class Wall:
    """A wall clock that only sleeping moves."""

    def __init__(self) -> None:
        self.now_s = 1000.0
        self.slept: list[float] = []

    def sleep(self, seconds: float) -> None:
        """Let time pass."""
        self.slept.append(seconds)
        self.now_s += seconds


def test_without_a_pace_nothing_waits() -> None:
    wall = Wall()
    clock = SimulatedClock(None, lambda: wall.now_s, wall.sleep)
    clock.advance(10_000_000)
    assert wall.slept == []


def test_a_pace_spreads_the_stamps_over_wall_time() -> None:
    wall = Wall()
    clock = SimulatedClock(2.0, lambda: wall.now_s, wall.sleep)
    for k in range(11):
        clock.advance(100_000 * k)
        wall.now_s += 0.01
    assert abs(wall.now_s - 0.01 - 1000.5) < 1e-6


def test_a_slow_tick_is_made_up_for_and_a_long_stop_is_given_up() -> None:
    wall = Wall()
    clock = SimulatedClock(1.0, lambda: wall.now_s, wall.sleep)
    clock.advance(0)
    wall.now_s += 0.25
    clock.advance(100_000)
    clock.advance(200_000)
    assert wall.slept == []
    clock.advance(300_000)
    assert abs(wall.now_s - 1000.3) < 1e-6
    wall.now_s += 60
    clock.advance(400_000)
    clock.advance(500_000)
    assert abs(wall.now_s - 1060.4) < 1e-6


def test_what_is_given_up_is_accounted_for_and_told_each_time_that_it_doubles() -> None:
    wall = Wall()
    notices: list[str] = []
    clock = SimulatedClock(1.0, lambda: wall.now_s, wall.sleep, notices.append)
    for k in range(801):
        clock.advance(10_000 * k)
        wall.now_s += 0.019
    assert wall.slept == []
    assert abs(clock.behind_s - 800 * 0.009) < 1e-6
    assert notices == [
        f"behind the wall clock by {behind_s} s: a tick takes 19 ms, the pace allows 10 ms"
        for behind_s in ("0.5", "1.0", "2.0", "4.1")
    ]


def test_a_clock_that_keeps_pace_is_not_behind() -> None:
    wall = Wall()
    notices: list[str] = []
    clock = SimulatedClock(4.0, lambda: wall.now_s, wall.sleep, notices.append)
    for k in range(250):
        clock.advance(10_000 * k)
        wall.now_s += 0.3 if k == 50 else 0.0001
    assert clock.behind_s == 0
    assert notices == []


def test_one_long_tick_stays_accounted_for() -> None:
    wall = Wall()
    notices: list[str] = []
    clock = SimulatedClock(2.0, lambda: wall.now_s, wall.sleep, notices.append)
    for k in range(100):
        clock.advance(1_000 * k)
        wall.now_s += 3.0 if k == 50 else 0.0001
    assert abs(clock.behind_s - 2.9995) < 1e-6
    assert notices == ["behind the wall clock by 3.0 s: a tick takes 59 ms, the pace allows 0.5 ms"]


def test_a_process_that_was_held_up_is_not_called_slow() -> None:
    wall = Wall()
    notices: list[str] = []

    def sleep(seconds: float) -> None:
        wall.sleep(seconds + (60 if len(wall.slept) == 5 else 0))

    clock = SimulatedClock(1.0, lambda: wall.now_s, sleep, notices.append)
    for k in range(20):
        clock.advance(100_000 * k)
        wall.now_s += 0.011
    assert notices == [
        "behind the wall clock by 59.9 s: the process was held up (a tick takes 11 ms, the pace allows 100 ms)"
    ]


def test_a_clock_without_a_pace_is_never_behind() -> None:
    wall = Wall()
    clock = SimulatedClock(None, lambda: wall.now_s, wall.sleep)
    clock.advance(0)
    wall.now_s += 60
    clock.advance(1000)
    assert clock.behind_s == 0
