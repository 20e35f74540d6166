"""Which stamps are accepted: they advance, and with their arrivals."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graphnav.live.inputs.sender_monitor import SenderMonitor

from .camera import Camera, reasons


def test_a_jittered_camera_is_accepted() -> None:
    camera = Camera(SenderMonitor(), jitter_s=0.02)
    assert not any(reasons(camera.send(500)))
    assert not any(verdict.is_restart for verdict in camera.verdicts)
    assert camera.monitor.accepted == 500
    assert not camera.monitor.fault(camera.arrival_s)
    assert camera.monitor.rate_hz(camera.arrival_s) == pytest.approx(20, rel=0.1)
    assert [v.utime for v in camera.verdicts] == sorted({v.utime for v in camera.verdicts})


def test_without_a_stamp_the_arrival_is_used_and_advances() -> None:
    monitor = SenderMonitor()
    verdicts = [monitor.judge(k * 1e-7, 10 + k // 10, None, None) for k in range(40)]
    assert all(verdict.accepted for verdict in verdicts)
    assert all(a.utime < b.utime for a, b in pairwise(verdicts))
    assert verdicts[0].utime == 10


@pytest.mark.parametrize("is_counting", [True, False])
def test_repeated_and_backward_stamps_are_rejected(is_counting: bool) -> None:
    camera = Camera(SenderMonitor(), is_counting=is_counting)
    camera.send(10)
    newest = camera.verdicts[-1].utime
    camera.seq -= 1
    again = camera.deliver(9 / 20)
    camera.arrival_s += 0.01
    camera.seq -= 1
    older = camera.deliver(8 / 20)
    assert (again.accepted, again.utime, again.reason) == (False, newest, "repeated")
    assert older.reason == "backwards"
    assert camera.monitor.rejected == {"repeated": 1, "backwards": 1}
    assert camera.monitor.detail("repeated") == "utime is that of an earlier message, expected a later time"
    assert camera.monitor.detail("backwards") == "utime is 0.050 s before that of the newest, expected later"
    camera.seq += 2
    assert not any(reasons(camera.send(5)))


def test_a_frozen_stamp_ages() -> None:
    camera = Camera(SenderMonitor(0.5))
    camera.send(10)
    for _ in range(100):
        camera.arrival_s += 0.05
        camera.seq += 1
        assert camera.deliver(9 / 20).reason == "repeated"
    assert camera.monitor.age_s(camera.arrival_s) == pytest.approx(5.0)


@pytest.mark.parametrize("jump_s", [3600.0, -3600.0, 0.8, -0.8])
@pytest.mark.parametrize("is_counting", [True, False])
def test_a_jump_that_passes_changes_nothing(jump_s: float, is_counting: bool) -> None:
    camera = Camera(SenderMonitor(0.5), is_counting=is_counting)
    camera.send(50)
    camera.offset_s = jump_s
    assert reasons(camera.send(3)) == ["jumped"] * 3
    assert camera.monitor.fault(camera.arrival_s) == f"the stamp jumped by {jump_s:+.1f} s against its arrival"
    camera.offset_s = 0
    after = camera.send(10)
    assert not any(reasons(after))
    assert camera.monitor.age_s(camera.arrival_s) == 0
    assert camera.monitor.fault(camera.arrival_s)
    assert not camera.monitor.fault(camera.arrival_s + 0.5)
    assert not any(verdict.is_restart for verdict in after)


@pytest.mark.parametrize("jump_s", [3600.0, -3600.0])
@pytest.mark.parametrize("is_counting", [True, False])
def test_a_jump_that_stays_is_adopted_after_five_messages(jump_s: float, is_counting: bool) -> None:
    camera = Camera(SenderMonitor(), jitter_s=0.01, is_counting=is_counting)
    camera.send(50)
    camera.offset_s = jump_s
    verdicts = camera.send(20)
    assert reasons(verdicts) == ["jumped"] * 4 + [""] * 16
    assert [verdict.is_restart for verdict in verdicts] == [False] * 4 + [True] + [False] * 15
    assert camera.monitor.offset_s == pytest.approx(jump_s, abs=0.01)
    assert camera.monitor.age_s(camera.arrival_s) < 0.02


def test_a_jump_early_in_the_count_is_adopted_too() -> None:
    camera = Camera(SenderMonitor())
    camera.send(6)
    camera.seq, camera.offset_s = 0, -3600
    assert reasons(camera.send(20))[5:] == [""] * 15


def test_a_flood_of_another_timeline_is_not_adopted_between_two_messages() -> None:
    camera = Camera(SenderMonitor(), rate_hz=10, is_counting=False)
    camera.send(20)
    for _ in range(20):
        begin_s = camera.arrival_s
        for k in range(1000):
            camera.arrival_s = begin_s + 0.09 * (k + 1) / 1000
            assert not camera.deliver(camera.arrival_s + 3600).accepted
        assert camera.send(1)[0].accepted


def test_a_gap_is_no_new_beginning() -> None:
    camera = Camera(SenderMonitor())
    camera.send(20)
    camera.pause(1.0)
    assert not camera.send(1)[0].is_restart


def test_half_of_the_messages_lost_is_another_rate() -> None:
    camera = Camera(SenderMonitor(), jitter_s=0.01)
    camera.send(20)
    for _ in range(100):
        camera.pause(0.05)
        camera.seq += 1
        camera.send(1)
    assert not any(reasons(camera.verdicts))
    assert not any(verdict.is_restart for verdict in camera.verdicts)
    assert camera.monitor.rate_hz(camera.arrival_s) == pytest.approx(10, rel=0.1)


_STEPS = st.lists(
    st.tuples(
        st.floats(0, 2),
        st.one_of(st.none(), st.integers(-5_000_000, 5_000_000), st.integers(-(2**62), 2**62)),
        st.one_of(st.integers(0, 3), st.integers(0, 1000)),
    ),
    max_size=60,
)


@settings(derandomize=True, deadline=None, max_examples=300)
@given(steps=_STEPS, max_age_s=st.one_of(st.none(), st.floats(0.05, 5)), counts=st.booleans())
def test_whatever_comes(steps: list[tuple[float, int | None, int]], max_age_s: float | None, counts: bool) -> None:
    monitor = SenderMonitor(max_age_s)
    arrival_s, newest, newest_s, seq = 0.0, None, 0.0, 0
    for wait_s, stamp, advance in steps:
        arrival_s += wait_s
        seq = seq + advance if advance <= 3 else advance
        verdict = monitor.judge(arrival_s, 10**15 + round(arrival_s * 1e6), stamp, seq if counts else None)
        assert verdict.accepted == (not verdict.reason)
        assert verdict.birth_s <= arrival_s
        if verdict.accepted:
            assert newest is None or verdict.utime > newest or verdict.is_restart
            newest, newest_s = verdict.utime, arrival_s
        assert monitor.age_s(arrival_s + 0.5) >= arrival_s + 0.5 - newest_s
    assert monitor.accepted + monitor.rejected.total() == len(steps)
