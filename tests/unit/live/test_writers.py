"""One writer an input: a second one is rejected while the first is alive, a restarted one is adopted."""

from __future__ import annotations

import pytest

from graphnav.live.inputs.sender_monitor import SenderMonitor, Verdict

from .camera import Camera, reasons


def _interleave(first: Camera, second: Camera, until_s: float) -> tuple[list[Verdict], list[Verdict]]:
    """Let two writers send in the order of time; return the verdicts of each."""
    verdicts: tuple[list[Verdict], list[Verdict]] = ([], [])
    while min(first.frame / first.rate_hz, second.frame / second.rate_hz) < until_s:
        is_second = second.frame / second.rate_hz + 0.02 < first.frame / first.rate_hz
        camera = second if is_second else first
        verdicts[is_second].extend(camera.send(1, 0.02 if is_second else 0.0))
    return verdicts


def _two(first_seq: int, second_seq: int, second_hz: float) -> tuple[Camera, Camera]:
    monitor = SenderMonitor()
    return Camera(monitor, seq=first_seq, rate_hz=10), Camera(monitor, seq=second_seq, rate_hz=second_hz)


@pytest.mark.parametrize("second_hz", [10, 7, 25])
@pytest.mark.parametrize("second_seq", [0, 5000, 1500])
def test_of_two_writers_the_first_is_kept(second_seq: int, second_hz: float) -> None:
    first, second = _two(1000, second_seq, second_hz)
    first.send(10)
    second.frame = round(second_hz)
    kept, others = _interleave(first, second, 60)
    assert not any(reasons(kept))
    assert set(reasons(others)) == {"second writer"}
    assert first.monitor.rejected["second writer"] == len(others)
    assert "a second writer: seq" in first.monitor.fault(first.arrival_s)


def test_a_fast_writer_that_passes_the_count_of_the_first_does_not_take_over() -> None:
    first, second = _two(1000, 0, 2000)
    first.send(10)
    second.frame = 2000
    kept, others = _interleave(first, second, 5)
    assert sum(verdict.accepted for verdict in kept) >= len(kept) - 1
    assert not any(verdict.accepted for verdict in others)


@pytest.mark.parametrize("ahead", [0, 1])
def test_of_two_equal_counts_one_is_kept(ahead: int) -> None:
    first, second = _two(0, ahead, 10)
    second.offset_s = 0.01
    verdicts = _interleave(first, second, 60)
    n_accepted = sorted(sum(verdict.accepted for verdict in each) for each in verdicts)
    assert n_accepted[0] <= 5
    assert n_accepted[1] >= 590
    assert "a second writer" in first.monitor.fault(max(first.arrival_s, second.arrival_s))


@pytest.mark.parametrize("down_s", [0.0, 0.2, 10.0])
@pytest.mark.parametrize("n_before", [3, 20, 500])
def test_a_restarted_sender_is_adopted(down_s: float, n_before: int) -> None:
    camera = Camera(SenderMonitor(0.5))
    camera.send(n_before)
    end_s = camera.arrival_s
    camera.pause(down_s)
    camera.seq = 0
    verdicts = camera.send(40)
    adopted = next(k for k, verdict in enumerate(verdicts) if verdict.accepted)
    assert verdicts[adopted].is_restart
    assert not any(reasons(verdicts[adopted:]))
    assert (n_before + round(down_s * 20) + adopted) / 20 - end_s <= max(0.6, down_s + 0.15)
    assert camera.monitor.age_s(camera.arrival_s) == pytest.approx(0, abs=0.01)


def test_a_sender_that_restarts_with_another_clock_is_adopted() -> None:
    camera = Camera(SenderMonitor())
    camera.send(100)
    camera.pause(3)
    camera.seq, camera.offset_s = 0, -camera.frame / 20 - 1.7e9
    assert not any(reasons(camera.send(10)))


def test_of_two_writers_the_second_is_adopted_once_the_first_is_silent() -> None:
    first, second = _two(1000, 0, 10)
    first.send(10)
    second.frame = 10
    _interleave(first, second, 10)
    verdicts = second.send(20)
    assert reasons(verdicts)[:4] == ["second writer"] * 4
    assert sum(verdict.is_restart for verdict in verdicts) == 1
    assert not any(reasons(verdicts[8:]))


def test_losses_within_what_the_time_explains_are_not_another_writer() -> None:
    camera = Camera(SenderMonitor())
    camera.send(20)
    camera.pause(30)
    camera.seq += 600
    assert not any(reasons(camera.send(5)))


def test_a_sender_that_does_not_count_is_one_writer() -> None:
    camera = Camera(SenderMonitor())
    for _ in range(50):
        camera.seq = 0
        camera.send(1)
    assert not any(reasons(camera.verdicts))


def test_an_edge_that_sends_twice_is_one_writer() -> None:
    camera = Camera(SenderMonitor())
    for _ in range(50):
        assert camera.send(1)[0].accepted
        camera.seq -= 1
        assert camera.deliver((camera.frame - 1) / 20).reason == "repeated"
        camera.seq += 1
    assert not camera.monitor.fault(camera.arrival_s)
