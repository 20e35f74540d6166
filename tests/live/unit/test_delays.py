"""How old an input is: what the edge delays is old, what clocks differ by is not."""

from __future__ import annotations

import math

import pytest

from graphnav.live.inputs.sender_monitor import SenderMonitor

from .camera import Camera, reasons


def test_age_before_the_first_message_is_infinite() -> None:
    monitor = SenderMonitor()
    assert monitor.age_s(3.0) == math.inf
    assert (monitor.accepted, monitor.offset_s, monitor.rate_hz(3.0), monitor.fault(3.0)) == (0, 0.0, 0.0, "")


@pytest.mark.parametrize("delay_s", [0.0, 0.05, 0.15])
def test_a_constant_delay_counts_where_clocks_agree(delay_s: float) -> None:
    camera = Camera(SenderMonitor())
    verdicts = camera.send(100, delay_s)
    assert not any(reasons(verdicts))
    assert camera.monitor.age_s(camera.arrival_s + 0.02) == pytest.approx(delay_s + 0.02, abs=1e-4)
    assert camera.arrival_s - verdicts[-1].birth_s == pytest.approx(delay_s, abs=1e-4)
    assert camera.monitor.offset_s == pytest.approx(-delay_s, abs=1e-4)


@pytest.mark.parametrize("offset_s", [1e6, -1e6])
def test_a_clock_of_another_epoch_is_not_a_delay(offset_s: float) -> None:
    camera = Camera(SenderMonitor(), offset_s=offset_s, jitter_s=0.01)
    camera.send(100, 0.05)
    assert camera.monitor.offset_s == pytest.approx(offset_s - 0.05, abs=1e-3)
    assert camera.monitor.age_s(camera.arrival_s) < 0.011
    assert not any(reasons(camera.send(1, 0.35)))
    assert camera.monitor.age_s(camera.arrival_s) == pytest.approx(0.3, abs=0.015)


@pytest.mark.parametrize("offset_s", [0.0, 1e6])
def test_an_edge_that_is_delayed_and_recovers(offset_s: float) -> None:
    camera = Camera(SenderMonitor(0.5), offset_s=offset_s)
    camera.send(50)
    delays = [2 * k / 40 for k in range(40)] + [2.0] * 40 + [2 - 2 * k / 40 for k in range(41)]
    for delay_s in delays:
        camera.send(1, delay_s)
        assert camera.monitor.age_s(camera.arrival_s) == pytest.approx(delay_s, abs=0.01)
    assert not any(reasons(camera.verdicts))
    assert not camera.monitor.fault(camera.arrival_s)


def test_a_sudden_delay_ends_in_a_burst() -> None:
    camera = Camera(SenderMonitor(0.5))
    camera.send(50)
    late = camera.send(1, 2.0)
    burst = camera.send(40, 0.0)
    assert not any(reasons(camera.verdicts))
    assert not any(verdict.is_restart for verdict in (*late, *burst))
    ages = [camera.arrival_s - verdict.birth_s for verdict in burst]
    assert ages == sorted(ages, reverse=True)
    camera.send(5)
    assert camera.monitor.age_s(camera.arrival_s) == pytest.approx(0, abs=0.01)


@pytest.mark.parametrize("drift_ratio", [100e-6, -100e-6])
def test_clocks_that_drift_for_a_day(drift_ratio: float) -> None:
    camera = Camera(SenderMonitor(1.0), rate_hz=1.0, drift_ratio=drift_ratio, jitter_s=0.01)
    oldest_s = 0.0
    for _ in range(24 * 3600):
        verdict = camera.send(1)[0]
        oldest_s = max(oldest_s, camera.arrival_s - verdict.birth_s)
        camera.verdicts.clear()
    assert camera.monitor.rejected.total() == 0
    assert camera.monitor.offset_s == pytest.approx(24 * 3600 * drift_ratio, abs=0.02)
    assert oldest_s < 1.05
    assert camera.monitor.age_s(camera.arrival_s) < 0.02


@pytest.mark.parametrize(("rate_hz", "max_age_s"), [(20, 0.3), (5, 1.0), (0.5, 5.0)])
def test_max_age_follows_the_usual_period(rate_hz: float, max_age_s: float) -> None:
    camera = Camera(SenderMonitor(), rate_hz=rate_hz)
    assert camera.monitor.max_age_s == 1.0
    camera.send(10)
    assert camera.monitor.max_age_s == pytest.approx(max_age_s)
    assert SenderMonitor(0.7).max_age_s == 0.7


def test_silence_has_no_rate() -> None:
    camera = Camera(SenderMonitor())
    camera.send(30)
    assert camera.monitor.rate_hz(camera.arrival_s + 0.25) == pytest.approx(20, rel=0.01)
    assert camera.monitor.rate_hz(camera.arrival_s + 0.4) == 0
    assert camera.monitor.age_s(camera.arrival_s + 9) == pytest.approx(9)


@pytest.mark.parametrize("offset_s", [0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6, 0.65, 0.7])
def test_whether_a_constant_offset_counts_as_age_is_decided_once(offset_s: float) -> None:
    camera = Camera(SenderMonitor(0.5), offset_s=-offset_s, jitter_s=0.03)
    camera.send(10)
    counts = camera.monitor.counts_offset
    for _ in range(5):
        camera.offset_s += 0.02  # a drift of less than the dead band
        camera.send(40)
        assert camera.monitor.counts_offset == counts
    assert counts == (offset_s < 0.5)
