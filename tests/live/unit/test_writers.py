"""One writer an input: a second one does no harm, takes over in silence, and stops a robot that has accepted none."""

from __future__ import annotations

import random
import re

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
    assert not first.monitor.fault(first.arrival_s), "a standby process does not stop the robot"
    detail = first.monitor.detail("second writer")
    assert detail.startswith(f"seq {second.seq - 1} beside ")
    assert detail.endswith(f", {second_hz:.1f} Hz; the first writer is used")


def test_a_fast_writer_that_passes_the_count_of_the_first_does_not_take_over() -> None:
    first, second = _two(1000, 0, 2000)
    first.send(10)
    second.frame = 2000
    kept, others = _interleave(first, second, 5)
    assert sum(verdict.accepted for verdict in kept) >= len(kept) - 1
    assert not any(verdict.accepted for verdict in others)


@pytest.mark.parametrize("second_seq", [0, 1, 17, 5230])
@pytest.mark.parametrize("first_seq", [0, 5000])
def test_of_two_writers_before_one_was_accepted_none_is_used(first_seq: int, second_seq: int) -> None:
    first, second = _two(first_seq, second_seq, 10)
    second.offset_s = 0.01
    kept, others = _interleave(first, second, 60)
    assert sum(verdict.accepted for verdict in (*kept, *others)) <= 3, "before the second one is noticed"
    now_s = max(first.arrival_s, second.arrival_s)
    fault = first.monitor.fault(now_s)
    assert fault == first.monitor.detail("second writer")
    assert re.fullmatch(r"two writers: seq \d+ and seq \d+; neither is used until one of them ends", fault)
    assert {int(number) for number in re.findall("seq ([0-9]+)", fault)} <= {
        number for camera in (first, second) for number in (camera.seq - 1, camera.seq - 2)
    }


@pytest.mark.parametrize("second_seq", [0, 5230])
@pytest.mark.parametrize("survivor", [0, 1])
def test_the_writer_that_remains_of_two_is_used_after_a_silence(survivor: int, second_seq: int) -> None:
    cameras = _two(0, second_seq, 10)
    cameras[1].offset_s = 0.01
    _interleave(*cameras, 5)
    last_s = cameras[1 - survivor].arrival_s
    remaining = cameras[survivor]
    verdicts = remaining.send(40)
    adopted = next(k for k, verdict in enumerate(verdicts) if verdict.accepted)
    assert verdicts[adopted].is_restart
    assert not any(reasons(verdicts[adopted:]))
    silent_s = remaining.arrival_s - (len(verdicts) - 1 - adopted) / 10 - last_s
    assert remaining.monitor.max_age_s - 0.6 <= silent_s <= 1.3
    assert not remaining.monitor.fault(remaining.arrival_s)


def test_a_standby_takes_over_twenty_times_through_one_stop_each() -> None:
    monitor = SenderMonitor(0.5)
    active, standby = Camera(monitor, seq=1000, rate_hz=10), Camera(monitor, seq=17, rate_hz=10)
    active.send(20)
    standby.frame = 20
    for _ in range(20):
        _interleave(active, standby, standby.frame / 10 + 2)
        assert not monitor.fault(active.arrival_s)
        silent_since_s = active.arrival_s
        verdicts = standby.send(20)
        adopted = next(k for k, verdict in enumerate(verdicts) if verdict.accepted)
        accepted_s = standby.arrival_s - (len(verdicts) - 1 - adopted) / 10
        assert 0.5 < accepted_s - silent_since_s < 0.72
        assert sum(verdict.is_restart for verdict in verdicts) == 1
        assert not any(reasons(verdicts[adopted:]))
        assert monitor.fault(accepted_s).startswith("another writer took over: seq ")
        assert monitor.fault(accepted_s + 0.5)
        assert not monitor.fault(accepted_s + 0.51)
        active.frame = standby.frame
        active, standby = standby, active


def test_the_former_writer_that_comes_back_is_the_second_one() -> None:
    first, second = _two(1000, 0, 10)
    first.send(20)
    second.frame = 20
    _interleave(first, second, 4)
    second.send(20)
    first.frame, first.seq = second.frame, first.seq + 20
    kept, others = _interleave(second, first, second.frame / 10 + 5)
    assert not any(reasons(kept))
    assert set(reasons(others)) == {"second writer"}
    assert not first.monitor.fault(first.arrival_s)


def test_writers_without_numbers_are_told_apart_by_where_they_send_from() -> None:
    monitor = SenderMonitor(0.5)
    camera = Camera(monitor, rate_hz=10, is_counting=False, writers=("10.0.0.1:5001",))
    assert not any(reasons(camera.send(20)))
    camera.writers = "10.0.0.1:5001", "10.0.0.2:5002"
    assert set(reasons(camera.send(20))) == {"second writer"}
    assert monitor.fault(camera.arrival_s) == (
        "2 writers without sequence numbers: 10.0.0.1:5001, 10.0.0.2:5002; none is used until one remains"
    )
    camera.writers = ("10.0.0.2:5002",)
    verdicts = camera.send(20)
    assert [verdict.is_restart for verdict in verdicts] == [True] + [False] * 19
    assert not any(reasons(verdicts))
    assert not monitor.fault(camera.arrival_s)


def test_numbers_count_more_than_where_messages_come_from() -> None:
    camera = Camera(SenderMonitor(), writers=("10.0.0.1:5001", "10.0.0.1:5002"))
    assert not any(reasons(camera.send(50))), "one program may send from two sockets"


def test_two_zeroed_structs_are_told_apart_by_where_they_send_from() -> None:
    camera = Camera(SenderMonitor(), writers=("10.0.0.1:5001", "10.0.0.1:5002"))
    for _ in range(20):
        camera.seq = 0
        camera.send(1)
    assert reasons(camera.verdicts)[1:] == ["second writer"] * 19


@pytest.mark.parametrize("share", [0.05, 0.3])
@pytest.mark.parametrize("is_counting", [True, False])
def test_jitter_duplicates_and_reordering_are_no_second_writer(is_counting: bool, share: float) -> None:
    """The network delays, repeats and swaps messages of one writer."""
    noise = random.Random(5)
    camera = Camera(SenderMonitor(), is_counting=is_counting, writers=("10.0.0.1:5001",))
    due: list[tuple[float, float, int]] = []
    for k in range(2000):
        sent_s = k / 20 + noise.uniform(0, 0.01)
        due.append((sent_s + (noise.uniform(0, 0.12) if noise.random() < share else 0.0), sent_s, k))
        if noise.random() < share:
            due.append((sent_s + noise.uniform(0, 0.12), sent_s, k))
    for arrival_s, sent_s, seq in sorted(due):
        camera.arrival_s, camera.seq = arrival_s, seq
        camera.verdicts.append(camera.deliver(sent_s))
    assert set(reasons(camera.verdicts)) <= {"", "repeated", "backwards"}
    assert not camera.monitor.fault(camera.arrival_s)


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


OWN, ANOTHER = ("10.0.0.5:41234 (pid 77, camera)",), ("10.0.0.5:50001",)


@pytest.mark.parametrize(
    ("count", "seqs"),
    [(20, range(30)), (5230, range(30)), (5230, range(5230, 5200, -1)), (5230, range(10_000, 40_000, 1000))],
    ids=["within its numbers", "from 0", "backwards", "by jumps"],
)
def test_numbers_of_the_only_writer_that_start_again_are_not_of_a_second_one(count: int, seqs: range) -> None:
    camera = Camera(SenderMonitor(0.5), seq=count, rate_hz=10, writers=OWN)
    camera.send(20)
    last = camera.seq - 1
    verdicts = []
    for seq in seqs:
        camera.seq = seq
        verdicts += camera.send(1)
        if len(verdicts) < 5:
            assert camera.monitor.detail("restarted") == (
                f"seq is {seq} after {last}, expected {last + 1}, from the same program, {OWN[0]}: its driver has "
                "started again, or its message was zeroed"
            )
    assert set(reasons(verdicts[:4])) == {"restarted"}
    assert not camera.monitor.rejected["second writer"]
    assert camera.monitor.missing == 0
    adopted = next(verdict for verdict in verdicts if verdict.accepted)
    assert adopted.is_restart, "the robot stops, as for another writer"


def test_a_sender_that_starts_again_is_used_after_a_fault_that_tells_it() -> None:
    camera = Camera(SenderMonitor(0.5), seq=5000, rate_hz=10, writers=OWN)
    camera.send(20)
    camera.seq = 0
    while not camera.send(1)[0].accepted:
        assert camera.seq < 10
    fault = camera.monitor.fault(camera.arrival_s)
    assert fault.startswith(f"seq is {camera.seq - 1} after 5019, expected 5020, from the same program, ")
    assert not any(reasons(camera.send(20)))
    assert not camera.monitor.fault(camera.arrival_s)


def test_a_restart_is_told_although_the_packet_of_the_last_message_before_it_was_noted_late() -> None:
    camera = Camera(SenderMonitor(0.5), seq=5000, rate_hz=10, writers=OWN)
    camera.send(20)
    camera.writers = ()
    camera.send(1)
    camera.writers, camera.seq = OWN, 0
    assert set(reasons(camera.send(4))) == {"restarted"}


def test_the_program_of_a_former_writer_is_not_that_of_the_next_one() -> None:
    monitor = SenderMonitor(0.5)
    first, second = (Camera(monitor, seq=seq, rate_hz=10, writers=OWN) for seq in (1000, 17))
    first.send(20)
    second.writers, second.frame = (), 40
    while not second.send(1)[0].accepted:
        assert second.seq < 30
    first.frame = second.frame
    assert reasons(first.send(1)) == ["second writer"]


def test_a_second_writer_whose_packet_was_noted_late_is_one() -> None:
    monitor = SenderMonitor(5)
    first, second = (Camera(monitor, seq=seq, rate_hz=10, writers=OWN) for seq in (1000, 17))
    first.send(10)
    second.frame = 10
    assert reasons(second.send(1)) == ["restarted"]
    first.writers = second.writers = OWN + ANOTHER
    first.frame = 11
    _, others = _interleave(first, second, 3)
    assert set(reasons(others)) == {"second writer"}
    assert monitor.fault(second.arrival_s).startswith("two writers: seq "), "neither was alone for max_age_s"


def test_a_writer_of_another_address_is_a_second_one() -> None:
    monitor = SenderMonitor(0.5)
    first, second = (Camera(monitor, seq=seq, rate_hz=10, writers=OWN) for seq in (1000, 17))
    first.send(10)
    first.writers = second.writers = OWN + ANOTHER
    second.frame = 10
    _, others = _interleave(first, second, 5)
    assert set(reasons(others)) == {"second writer"}
    second.writers = ANOTHER
    while not second.send(1)[0].accepted:
        assert second.seq < 100
    assert monitor.fault(second.arrival_s).startswith("another writer took over: seq ")
