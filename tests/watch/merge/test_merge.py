"""Logs of two computers are merged: clocks found within the error that is stated, names, descriptions, broken logs."""

from __future__ import annotations

import json
import random
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from graphnav import About, Recording, Twist
from graphnav.core.cli import main
from graphnav.core.codec import decode, encode
from graphnav.core.messages import Message
from graphnav.core.record import LogWriter

BEGIN_US = 1_700_000_000_000_000
AHEAD_US = 3_600_000_000
GRAPH = "stages: {{guard: {{use: x.y, in: {{}}}}}}\ninputs: {{{source}: {{channel: {channel}, type: x}}}}\n"
Clock = Callable[[int], int]
"""The reading of a clock at the first log's time."""


def about(made: str, received: str, run_id: str = "") -> bytes:
    graph = GRAPH.format(source=received, channel=received.upper())
    names = (made, received, "graphnav.status")
    twist = "graphnav_lcm.twist_t"
    return encode(About(graph, "", run_id, 0, names, (twist, twist, "graphnav_lcm.status_t")), BEGIN_US, 0)


def pair(
    folder: Path,
    clock: Clock,
    seconds: float = 20.0,
    ways: Sequence[str] = ("there", "back"),
    *,
    is_described: bool = True,
) -> tuple[Path, Path]:
    """Write the logs of two hosts that talk for some seconds; the second one has another clock."""
    draw = random.Random(3)
    events: tuple[list[Any], list[Any]] = ([], [])
    for number in range(int(seconds * 20)):
        for way in ways:
            sent_us = BEGIN_US + number * 50_000 + draw.randrange(20_000)
            took_us = 400 + round(draw.expovariate(1 / 1500))
            data = encode(Twist(v_mps=0.1, omega_radps=0.0), sent_us, number)
            if way == "there":
                events[0].append((sent_us, "a.out", data))
                events[1].append((sent_us + took_us, "b.in", data))
            else:
                events[1].append((sent_us, "b.out", data))
                events[0].append((sent_us + took_us, "a.in", data))
    paths = folder / "robot.lcmlog", folder / "laptop.lcmlog"
    for place, (path, made, received) in enumerate(zip(paths, ("a.out", "b.out"), ("a.in", "b.in"), strict=True)):
        with LogWriter(path) as log:
            if is_described:
                log.write(About.CHANNEL, BEGIN_US if not place else clock(BEGIN_US), about(made, received))
            log.write("guard.state", BEGIN_US if not place else clock(BEGIN_US), b"of log %d" % place)
            for at_us, channel, data in sorted(events[place], key=lambda event: event[0]):
                log.write(channel, at_us if not place else clock(at_us), data)
    return paths


def merged(capsys: pytest.CaptureFixture[str], *words: object) -> dict[str, Any]:
    target = Path(str(words[0])).parent / "merged.lcmlog"
    assert main(["merge", *map(str, words), "-o", str(target), "--json", "--force"]) == 0
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


def refused(capsys: pytest.CaptureFixture[str], *words: object) -> str:
    assert main(["merge", *map(str, words)]) in (1, 2)
    printed = capsys.readouterr()
    assert not printed.out
    assert "Traceback" not in printed.err
    return printed.err


def drifting(ppm: float) -> Clock:
    return lambda at_us: at_us + AHEAD_US + round((at_us - BEGIN_US) * ppm * 1e-6)


@pytest.mark.parametrize(("seconds", "ppm"), [(20.0, 0.0), (600.0, 30.0), (600.0, -150.0)])
def test_offset_and_drift_are_found_within_the_stated_error(
    seconds: float, ppm: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robot, laptop = pair(tmp_path, drifting(ppm), seconds)
    other = merged(capsys, robot, laptop)["logs"][1]
    assert abs(other["ahead_us"] - AHEAD_US) <= other["error_us"] < 3_000
    assert abs(other["drift_ppm"] - ppm) <= other["drift_error_ppm"]
    assert not other["set"]
    assert other["from_there"] == other["back"] == seconds * 20
    with Recording(tmp_path / "merged.lcmlog") as log:
        arrived = dict(zip(log.utimes("b.in"), log.event_utimes("b.in"), strict=True))
        took_us = [
            arrived[stamp] - sent for stamp, sent in zip(log.utimes("a.out"), log.event_utimes("a.out"), strict=True)
        ]
    with Recording(robot) as log:
        assert log.event_utimes("a.out") == sorted(arrived)
    assert min(took_us) + other["error_us"] > 0
    assert max(took_us) < 20_000


@pytest.mark.parametrize("by_us", [250_000, -250_000])
def test_a_clock_that_is_set_is_noticed(by_us: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    at_us = BEGIN_US + 30_000_000
    robot, laptop = pair(tmp_path, lambda us: us + AHEAD_US + (by_us if us >= at_us else 0), 60.0)
    found = merged(capsys, robot, laptop)
    other = found["logs"][1]
    (set_once,) = other["set"]
    assert abs(set_once["at_us"] - AHEAD_US - at_us) < 500_000
    if by_us > 0:
        assert abs(set_once["by_us"] - by_us) <= 2 * other["error_us"]
    else:  # it is corrected where the log is read, up to the time between two events
        assert any("its timestamps jump" in notice for notice in found["notices"])
    with Recording(tmp_path / "merged.lcmlog") as log:
        sent = dict(zip(log.utimes("a.out"), log.event_utimes("a.out"), strict=True))
        late = [at - sent[stamp] for stamp, at in zip(log.utimes("b.in"), log.event_utimes("b.in"), strict=True)]
    assert max(map(abs, late)) < (20_000 if by_us > 0 else 60_000)


def test_one_direction_tells_the_offset_up_to_a_delay(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    other = merged(capsys, *pair(tmp_path, drifting(0.0), ways=["there"]))["logs"][1]
    assert other["error_us"] is None
    assert 400 <= other["ahead_us"] - AHEAD_US < 1_500


def test_logs_of_loggers_need_to_be_told_who_sent(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    robot, laptop = pair(tmp_path, drifting(0.0), is_described=False)
    unknown = merged(capsys, robot, laptop)["logs"][1]
    assert unknown["unknown"] == 800
    assert unknown["error_us"] is None
    assert abs(unknown["ahead_us"] - AHEAD_US) < 3_000
    told = merged(capsys, robot, laptop, "--sent", "robot:a.out", "--sent", "laptop:b.out")["logs"][1]
    assert abs(told["ahead_us"] - AHEAD_US) <= told["error_us"] < 2_000


def test_what_the_first_log_holds_stays_and_taken_names_get_a_prefix(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robot, laptop = pair(tmp_path, drifting(0.0))
    renamed = merged(capsys, robot, f"base={laptop}")["logs"][1]["renamed"]
    assert renamed == {"guard.state": "base.guard.state", "graphnav.status": "base.graphnav.status"}
    with Recording(robot) as before, Recording(tmp_path / "merged.lcmlog") as log:
        assert log.at(0).channel == About.CHANNEL
        kept = [event for event in log.events() if event.channel in ("a.out", "a.in", "guard.state")]
        assert kept == [event for event in before.events() if event.channel != About.CHANNEL]
        abouts = [decode(About, log.event(About.CHANNEL, index).data)[2] for index in range(2)]
        assert [one.run_id for one in abouts] == ["robot", "base"]
        assert abouts[1].channels == ("b.out", "b.in", "base.graphnav.status")
        times = [entry.utime for entry in log.entries()]
    assert times == sorted(times)


def test_one_copy_of_each_message(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log, other = tmp_path / "a.lcmlog", tmp_path / "b.lcmlog"
    messages: list[tuple[int, Message]] = [(BEGIN_US + 1000 * n, Twist(v_mps=n, omega_radps=0.0)) for n in range(30)]
    for path, part in ((log, messages[:20]), (other, messages[10:])):
        with LogWriter(path) as writer:
            for at_us, message in part:
                writer.write("CMD", at_us, encode(message, at_us, 0))
    both = merged(capsys, log, other)
    assert both["messages"] == 40
    assert both["logs"][1]["renamed"] == {"CMD": "b.CMD"}
    one = merged(capsys, log, other, "--once")
    assert one["messages"] == 30
    assert one["logs"][1]["left_out"] == 10
    assert not one["logs"][1]["renamed"]


def test_an_offset_by_hand(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    robot, laptop = pair(tmp_path, drifting(0.0), ways=["there"])
    for words in (["--offset", "3600.5"], ["--offset", "laptop:3600.5"]):
        other = merged(capsys, robot, laptop, *words)["logs"][1]
        assert (other["ahead_us"], other["error_us"], other["measured_by"]) == (3_600_500_000, 0, None)


def test_a_third_log_is_measured_by_the_one_that_it_shares_messages_with(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robot, laptop = pair(tmp_path, drifting(0.0))
    third = tmp_path / "third.lcmlog"
    with Recording(laptop) as log, LogWriter(third) as writer:
        for event in log.events():
            if event.channel == "b.out":
                writer.write("c.in", event.utime + 5_000_000, event.data)
    with Recording(robot) as log:
        kept = [event for event in log.events() if event.channel != "a.in"]
    with LogWriter(robot) as writer:
        for event in kept:
            writer.write(*event)
    logs = merged(capsys, robot, third, laptop)["logs"]
    assert [one["measured_by"] for one in logs] == [None, "laptop", "robot"]
    assert abs(logs[1]["ahead_us"] - AHEAD_US - 5_000_000) < 2_000


class TestRefused:
    def test_nothing_shared(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        robot, laptop = pair(tmp_path, drifting(0.0), ways=[])
        assert "--offset laptop:SECONDS" in refused(capsys, robot, laptop, "-o", tmp_path / "m.lcmlog")
        assert not (tmp_path / "m.lcmlog").exists()

    def test_the_same_log(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        robot, _ = pair(tmp_path, drifting(0.0), 1.0)
        copy = tmp_path / "copy.lcmlog"
        copy.write_bytes(robot.read_bytes())
        (link := tmp_path / "link.lcmlog").symlink_to(robot)
        assert "are the same log" in refused(capsys, robot, link, "-o", tmp_path / "m.lcmlog")
        assert "are the same log" in refused(capsys, robot, robot, "-o", tmp_path / "m.lcmlog")
        assert "hold the same events" in refused(capsys, robot, copy, "-o", tmp_path / "m.lcmlog")

    def test_what_it_would_replace(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        robot, laptop = pair(tmp_path, drifting(0.0), 1.0)
        (target := tmp_path / "m.lcmlog").write_text("mine")
        assert "add --force" in refused(capsys, robot, laptop, "-o", target)
        assert "one of the logs to merge" in refused(capsys, robot, laptop, "-o", laptop, "--force")
        assert target.read_text() == "mine"

    def test_simulated_time(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        robot, _ = pair(tmp_path, drifting(0.0), 1.0)
        simulated = tmp_path / "drive.lcmlog"
        with LogWriter(simulated) as log:
            log.write(About.CHANNEL, 0, encode(About("stages: {}", "", "", 0, ("a",), ("b.c_t",)), 0, 0))
        assert "holds simulated time" in refused(capsys, robot, simulated, "-o", tmp_path / "m.lcmlog")

    def test_names(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        robot, laptop = pair(tmp_path, drifting(0.0), 1.0)
        target = tmp_path / "m.lcmlog"
        assert "two logs have the name 'x'" in refused(capsys, f"x={robot}", f"x={laptop}", "-o", target)
        assert "no log has the name 'y'" in refused(capsys, robot, laptop, "-o", target, "--offset", "y:1")
        assert "the one that counts" in refused(capsys, robot, laptop, "-o", target, "--offset", "robot:1")
        assert "only one log is given" in refused(capsys, robot, "-o", target)

    def test_times_before_1970(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        robot, laptop = pair(tmp_path, drifting(0.0), 1.0)
        with LogWriter(laptop) as log:
            log.write("x", 5, b"")
        assert "before 1970" in refused(capsys, robot, laptop, "-o", tmp_path / "m.lcmlog", "--offset", "1")

    def test_no_log(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        robot, laptop = pair(tmp_path, drifting(0.0), 1.0)
        laptop.write_bytes(random.Random(1).randbytes(5000))
        assert "is not an LCM log" in refused(capsys, robot, laptop, "-o", tmp_path / "m.lcmlog")
        laptop.write_bytes(b"")
        assert "is empty" in refused(capsys, robot, laptop, "-o", tmp_path / "m.lcmlog")

    @pytest.mark.parametrize("at_us", [(1 << 63) - 1, -(1 << 63)])
    def test_no_clock(self, at_us: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        robot, laptop = pair(tmp_path, drifting(0.0), 1.0)
        with LogWriter(laptop) as log:
            log.write("x", at_us, b"")
            log.write("x", at_us, b"")
        assert "not those of a clock" in refused(capsys, robot, laptop, "-o", tmp_path / "m.lcmlog", "--offset", "0")

    def test_a_full_disk(
        self, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        robot, laptop = pair(tmp_path, drifting(0.0), 1.0)

        def full(*_: object) -> int:
            raise OSError(28, "No space left on device")

        monkeypatch.setattr("os.writev", full)
        said = refused(capsys, robot, laptop, "-o", tmp_path / "m.lcmlog")
        assert said.startswith(f"cannot write {tmp_path / 'm.lcmlog'}: No space left on device\n  make room")
        assert {path.name for path in tmp_path.iterdir()} == {"robot.lcmlog", "laptop.lcmlog"}


def test_equal_payloads_tell_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    robot, laptop = tmp_path / "a.lcmlog", tmp_path / "b.lcmlog"
    for path, n in ((robot, 20_000), (laptop, 10_000)):
        with LogWriter(path) as log:
            for number in range(n):
                log.write("x", BEGIN_US + number, b"the same")
    assert "shares no message" in refused(capsys, robot, laptop, "-o", tmp_path / "m.lcmlog")


def test_the_rest_of_a_damaged_log_is_merged(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    robot, laptop = pair(tmp_path, drifting(0.0))
    data = bytearray(laptop.read_bytes())
    data[len(data) // 2 : len(data) // 2 + 40] = bytes(40)
    laptop.write_bytes(data[:-10])
    found = merged(capsys, robot, laptop)
    assert any("is damaged" in notice for notice in found["notices"])
    assert abs(found["logs"][1]["ahead_us"] - AHEAD_US) <= found["logs"][1]["error_us"]


def test_a_damaged_timestamp_moves_nothing_else(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    robot, laptop = pair(tmp_path, drifting(0.0))
    with Recording(laptop) as log:
        events = list(log.events())
    with LogWriter(laptop) as writer:
        for number, event in enumerate(events):
            writer.write(event.channel, (1 << 63) - 1 if number in (0, 100) else event.utime, event.data)
    other = merged(capsys, robot, laptop)["logs"][1]
    assert abs(other["ahead_us"] - AHEAD_US) <= other["error_us"]
