"""Watching: every channel with type, rate, size and contents, live and in logs."""

from __future__ import annotations

import itertools
import json
import re
import signal
import subprocess
import sysconfig
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graphnav.core.bus import Bus
from graphnav.core.cli import main
from graphnav.core.codec import encode, lcm_name
from graphnav.core.messages import About, Flow, Message, State, Twist
from graphnav.core.record import LogWriter
from graphnav.core.tap import Tap
from graphnav.watch.feed import Feed, Watch
from graphnav.watch.spy import as_text

TYPES: dict[str, type[Message]] = {"flow.flow": Flow, "control.twist": Twist, "robot.state": State}
SAID = About("stages: {}\n", "", "", 7, tuple(TYPES), tuple(lcm_name(m.lcm_class) for m in TYPES.values()))
FLOW = Flow(
    uv_px=np.linspace(-1, 1, 24, dtype=np.float32).reshape(3, 4, 2),
    valid=np.array([[1, 1, 1, 0]] * 3, dtype=np.uint8),
    interval_us=100_000,
)
TENTH = {"min": pytest.approx(0.1), "max": pytest.approx(0.1), "std": pytest.approx(0, abs=1e-9)}


def twist_at(k: int, period_us: int = 100_000) -> bytes:
    """Return the k-th command."""
    return encode(Twist(0.1, 0.2), period_us * k, k)


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """Return a run folder whose log holds 21 flows and commands at 10 Hz, and one promised channel without messages."""
    with LogWriter(tmp_path / "run.lcmlog") as writer:
        writer.write(About.CHANNEL, 0, encode(SAID, 0, 0))
        for k in range(21):
            writer.write("flow.flow", 100_000 * k, encode(FLOW, 100_000 * k, k))
            writer.write("control.twist", 100_000 * k, twist_at(k))
    return tmp_path


def test_hz_says_that_nothing_comes_any_more(group: str) -> None:
    command = [str(Path(sysconfig.get_path("scripts")) / "graphnav"), "hz", "x", group]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        over = threading.Event()

        def publish() -> None:
            bus = Bus(group)
            for k in itertools.count():
                bus.publish("x", twist_at(k))
                if over.wait(0.01):
                    break
            bus.close()

        thread = threading.Thread(target=publish)
        thread.start()
        lines = iter(process.stdout.readline, "")
        first = next(lines)
        over.set()
        thread.join()
        silent = next(line for line in lines if "no new messages" in line)
        process.send_signal(signal.SIGINT)
        assert process.wait(30) == 130
    assert first.startswith("x  by stamp: average rate: 10.000, ")
    assert re.fullmatch(r"x  no new messages for \d+\.\d s; 40 B, \d+ messages\n", silent)


def test_spy_lists_the_channels_of_a_log(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["spy", str(log)]) == 0
    said = capsys.readouterr().out
    assert f"{log}: 4 channels\n" in said
    assert "flow.flow  graphnav_lcm.flow_t, 10.00 Hz, 152 B, 21 messages\n" in said
    assert "    uv_px        float32 (3, 4, 2)  -1 to 1, mean 0\n" in said
    assert "robot.state  graphnav_lcm.state_t, not received\n" in said
    assert "    moving       double[n_moving][3]\n" in said


def test_without_fields_there_is_a_line_for_each_channel(log: Path) -> None:
    feed, watch = Feed(str(log)), Watch()
    for received in feed.listen(None):
        assert received is not None
        watch.receive(received)
    lines = as_text(watch, "heading", with_fields=False).plain.splitlines()
    assert [line.split("  ")[0] for line in lines] == ["heading", *sorted([About.CHANNEL, *TYPES])]


def test_spy_tells_programs_the_same(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["spy", "--json", str(log / "run.lcmlog")]) == 0
    channels = json.loads(capsys.readouterr().out)["channels"]
    assert set(channels) == {About.CHANNEL, *TYPES}
    assert channels["flow.flow"] | {"fields": None, "wall_rate_hz": None} == {
        "type": "graphnav_lcm.flow_t",
        "messages": 21,
        "rate_hz": pytest.approx(10),
        "wall_rate_hz": None,
        "silent_s": None,
        **{f"{clock}_{name}_s": TENTH[name] for clock in ("period", "wall_period") for name in TENTH},
        "bytes": 152,
        "bytes_per_s": pytest.approx(1520),
        "min_bytes": 152,
        "mean_bytes": 152,
        "max_bytes": 152,
        "lost": 0,
        "lost_since_restart": 0,
        "undecodable": 0,
        "fields": None,
    }
    assert channels["flow.flow"]["fields"]["rows"] == 3


def test_hz_tells_the_rate_in_a_log(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["hz", "control.twist", str(log)]) == 0
    said = "average rate: 10.000, min: 0.100s max: 0.100s std dev: 0.00000s window: 21"
    assert capsys.readouterr().out == f"control.twist  {said}; 40 B, 21 messages\n"


def test_echo_prints_messages_of_a_log(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["echo", "control.twist", str(log), "-n", "2"]) == 0
    first = "control.twist  graphnav_lcm.twist_t, 40 B\n    utime        0\n    seq          0\n"
    said = capsys.readouterr().out
    assert said.startswith(first)
    assert said.count("v_mps        0.1\n") == 2
    assert main(["echo", "control.twist", str(log), "--json"]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [line["fields"]["seq"] for line in lines] == list(range(21))


def test_echo_shows_a_damaged_message(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with LogWriter(tmp_path / "log") as writer:
        writer.write("x", 0, twist_at(0)[:-1])
        writer.write("x", 0, twist_at(1))
    assert main(["echo", "x", str(tmp_path / "log")]) == 0
    assert capsys.readouterr().out.splitlines()[:2] == ["x  graphnav_lcm.twist_t, 39 B", "    undecodable"]


def test_a_truncated_log_is_shown_with_a_notice(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = log / "run.lcmlog"
    path.write_bytes(path.read_bytes()[:-3])
    assert main(["spy", str(path)]) == 0
    assert "the last event, 78 bytes from byte" in capsys.readouterr().out


@pytest.mark.parametrize("command", [["hz", "flow.flo"], ["echo", "flow.flo"]])
def test_a_channel_that_is_not_there_is_a_users_error(
    log: Path, capsys: pytest.CaptureFixture[str], command: list[str]
) -> None:
    assert main([*command, str(log)]) == 2
    assert capsys.readouterr().err == f"{log} has no channel 'flow.flo'\n  did you mean 'flow.flow'?\n"


def test_a_promised_channel_without_messages_is_said(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["hz", "robot.state", str(log)]) == 1
    assert capsys.readouterr().err == f"no message on channel 'robot.state' in {log}\n"


@pytest.mark.parametrize(
    ("name", "status", "text"),
    [
        ("nothing", 2, "there is no {}\n  name a run folder, a log, a udpm:// URL or a computer: robot.local:\n"),
        (".", 2, "{} holds no run.lcmlog\n  name a run folder, a log, a udpm:// URL or a computer: robot.local:\n"),
        ("empty", 1, "{} is empty\n"),
        ("foreign", 1, "{} is not an LCM log\n"),
    ],
)
def test_a_source_that_is_none_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, status: int, text: str
) -> None:
    (tmp_path / "empty").touch()
    (tmp_path / "foreign").write_text("stages: {}\n")
    assert main(["spy", str(tmp_path / name)]) == status
    assert capsys.readouterr().err == text.format(tmp_path / name)


def test_a_silent_group_is_said(group: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["spy", "--once", "--for", "0.05", group]) == 1
    assert capsys.readouterr().err.startswith(f"no message on {group} within 0.05 s\n  start a run")


def test_without_a_terminal_a_silent_group_is_said_once(group: str) -> None:
    command = [str(Path(sysconfig.get_path("scripts")) / "graphnav"), "spy", group]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        assert [process.stderr.readline(), process.stderr.readline()] == [
            f"no message on {group} within 3 s\n",
            "  start a run: graphnav run GRAPH --pace 1\n",
        ]
        process.send_signal(signal.SIGINT)
        assert process.wait(30) == 130
        assert process.stderr.read() == "stopped\n"


@pytest.fixture
def live(group: str) -> Iterator[str]:
    """Return the group of a run that goes on, stamped 10 Hz, until the test ends; one message in 50 is garbage."""
    over = threading.Event()

    def run() -> None:
        tap = Tap("thin", "run-1", group)
        tap.announce(SAID)
        big = Flow(np.zeros((120, 160, 2), np.float32), np.ones((120, 160), np.uint8), 100_000)
        k = 0
        while not over.wait(0.005):
            tap.write("flow.flow", 100_000 * k, encode(big, 100_000 * k, k))
            tap.write("control.twist", 100_000 * k, twist_at(k) if k % 50 else b"garbage")
            k += 1
        tap.close()

    thread = threading.Thread(target=run)
    thread.start()
    yield group
    over.set()
    thread.join()


def test_a_live_run_is_seen(live: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["spy", "--json", "--for", "1.5", live]) == 0
    seen: dict[str, Any] = json.loads(capsys.readouterr().out)
    assert seen["runs"] == ["run-1"]
    channels = seen["channels"]
    assert set(channels) == {About.CHANNEL, *TYPES}
    assert {name: channels[name]["type"] for name in TYPES} == dict(zip(SAID.channels, SAID.types, strict=True))
    assert channels["flow.flow"]["rate_hz"] == pytest.approx(10, rel=0.02)
    assert channels["control.twist"]["rate_hz"] == pytest.approx(10, rel=0.02)
    assert channels["flow.flow"]["fields"]["uv_px"]["shape"] == [60, 80, 2]
    assert channels["flow.flow"]["fields"]["step_px"] == 2
    assert channels["robot.state"]["messages"] == 0


def test_a_live_channel_is_measured_and_echoed(live: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["hz", "control.twist", live, "--for", "0.5"]) == 0
    said = capsys.readouterr().out
    assert "control.twist  by stamp: average rate: 10.000, min: 0.100s max: 0.100s std dev: 0.00000s window: " in said
    assert "control.twist  by arrival: average rate: " in said
    assert main(["echo", "flow.flow", live, "-n", "3", "--json"]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [line["fields"]["uv_px"]["shape"] for line in lines] == [[60, 80, 2]] * 3


def test_a_live_channel_that_the_run_does_not_have_is_said_at_once(
    live: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["echo", "flow.flaw", live]) == 2
    assert "did you mean 'flow.flow'?" in capsys.readouterr().err


def test_garbage_on_the_group_harms_no_viewer(group: str, capsys: pytest.CaptureFixture[str]) -> None:
    over = threading.Event()

    def shout() -> None:
        bus = Bus(group)
        while not over.wait(0.005):
            bus.publish("noise", b"\xff" * 33)
            bus.publish(About.CHANNEL, b"\xff" * 33)
        bus.close()

    thread = threading.Thread(target=shout)
    thread.start()
    assert main(["spy", "--once", "--for", "0.3", group]) == 0
    over.set()
    thread.join()
    assert "noise  unknown type, " in capsys.readouterr().out
