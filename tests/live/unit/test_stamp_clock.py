"""The unit and the clock of stamps: by their values, and by how much they advance."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from graphnav.live.inputs.sender_monitor import SenderMonitor
from graphnav.live.inputs.stamp_clock import StampClock

from .camera import EPOCH_US, Camera

BOOT_S = 50_000.0
"""Monotonic time at the first message."""
EXPECTED = {1e-6: "look like seconds", 1e-3: "look like milliseconds", 1e3: "look like nanoseconds"}


def feed(clock: StampClock, stamp: Callable[[float], float], duration_s: float, begin_s: float = 0.0) -> str:
    """Add messages at 20 Hz; ``stamp``: their stamps, by seconds since the first. Return the fault at the end."""
    for k in range(round(duration_s * 20)):
        time_s = begin_s + k / 20
        clock.add(int(stamp(time_s)), BOOT_S + time_s, EPOCH_US + round(time_s * 1e6))
    return clock.fault


@pytest.mark.parametrize("ratio", EXPECTED)
@pytest.mark.parametrize("epoch_us", [EPOCH_US, round(BOOT_S * 1e6)])
def test_a_unit_is_recognized_by_the_value_of_three_stamps(ratio: float, epoch_us: int) -> None:
    clock = StampClock()
    assert EXPECTED[ratio] in feed(clock, lambda time_s: (epoch_us + time_s * 1e6) * ratio, 0.15)
    assert clock.is_boot_time == (epoch_us != EPOCH_US)


@pytest.mark.parametrize("ratio", [1.0, *EXPECTED])
def test_half_an_hour_after_boot_its_microseconds_are_not_taken_for_seconds_of_the_day(ratio: float) -> None:
    """From 1500 to 2200 s they are as many as seconds since 1970, and its nanoseconds as many as milliseconds."""
    up_s, clock = EPOCH_US * 1e-12, StampClock()
    for k in range(3):
        clock.add(int((up_s + k / 20) * 1e6 * ratio), up_s + k / 20, EPOCH_US + k * 50_000)
    assert clock.is_boot_time
    assert EXPECTED.get(ratio, "") in clock.fault
    assert bool(clock.fault) == (ratio != 1)


@pytest.mark.parametrize("ratio", EXPECTED)
def test_a_unit_of_an_unknown_epoch_is_recognized_by_its_advance(ratio: float) -> None:
    clock = StampClock()
    assert EXPECTED[ratio] in feed(clock, lambda time_s: (7777 + time_s) * 1e6 * ratio, 5.0)
    assert not clock.is_boot_time


@pytest.mark.parametrize("epoch_us", [EPOCH_US, round(BOOT_S * 1e6), 7_777_000_000, 0])
def test_microseconds_of_any_epoch_are_right(epoch_us: int) -> None:
    assert not feed(StampClock(), lambda time_s: epoch_us + time_s * 1e6 + 1, 10.0)


@pytest.mark.parametrize("rate", [0.4, 0.5, 2.0, 2.5])
def test_stamps_that_count_frames_at_a_wrong_rate_are_told(rate: float) -> None:
    fault = feed(StampClock(), lambda time_s: EPOCH_US + rate * time_s * 1e6, 5.0)
    wanted = "utime is the time of the data, not a count of frames at a nominal rate"
    assert fault == f"utime advances by {rate:.2f} s a second: {wanted}"
    assert not feed(StampClock(), lambda time_s: EPOCH_US + (0.7 if rate < 1 else 1.4) * time_s * 1e6, 10.0)


def test_a_clock_that_jumps_is_not_another_unit() -> None:
    assert not feed(StampClock(), lambda time_s: EPOCH_US + time_s * 1e6 + 2_000e6 * (time_s > 3), 10.0)


def test_zero_and_a_stamp_that_stays_are_told_and_forgotten_when_it_advances() -> None:
    clock = StampClock()
    assert feed(clock, lambda _: 0, 0.15) == "utime is 0: the sender sets no stamp"
    assert not feed(clock, lambda time_s: EPOCH_US + time_s * 1e6, 0.15, 1.0)
    assert not feed(clock, lambda _: EPOCH_US, 1.9, 2.0)
    assert feed(clock, lambda _: EPOCH_US, 0.3, 3.9).startswith("utime does not advance")
    assert not feed(clock, lambda time_s: EPOCH_US + time_s * 1e6, 0.05, 5.0)


def test_bursts_and_delays_are_not_another_unit() -> None:
    camera = Camera(SenderMonitor(0.5), jitter_s=0.03)
    for _ in range(20):
        camera.send(20)
        camera.send(1, 2.0)
        camera.send(40)
        assert not camera.monitor.stamp_fault


def test_a_wrong_unit_is_the_fault_of_the_input_and_not_a_jump() -> None:
    monitor = SenderMonitor()
    for k in range(40):
        monitor.judge(k / 20, EPOCH_US + k * 50_000, (EPOCH_US + k * 50_000) * 1000, k)
    assert monitor.fault(2.0) == "stamps look like nanoseconds: utime is in microseconds, divide by 1000"
