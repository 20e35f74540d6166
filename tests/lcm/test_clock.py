"""Simulated time passes at the pace that is asked for."""

from __future__ import annotations

from graphnav.clock import SimulatedClock


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
