"""``graphnav bw`` and ``hz``: bandwidth, sizes and rates of one channel or of all, live and in logs."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphnav.core.bus import Bus
from graphnav.core.cli import main
from graphnav.core.codec import encode
from graphnav.core.messages import Twist
from graphnav.core.record import LogWriter
from graphnav.watch.feed import Received, Watch


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """Return a log of 21 commands at 10 Hz, three messages that grow, and one alone."""
    path = tmp_path / "log"
    with LogWriter(path) as writer:
        for k in range(21):
            writer.write("control.twist", 100_000 * k, encode(Twist(0.1, 0.2), 100_000 * k, k))
            if k % 7 == 0:
                writer.write("CAMERA", 100_000 * k, bytes(1000 * (k + 1)))
        writer.write("once", 2_000_000, bytes(10))
    return path


@given(st.lists(st.tuples(st.floats(0.001, 1), st.integers(0, 10_000)), min_size=2, max_size=50))
def test_the_bandwidth_is_what_comes_after_the_first(messages: list[tuple[float, int]]) -> None:
    watch = Watch()
    at_s = 0.0
    for step_s, size in messages:
        at_s += step_s
        channel = watch.receive(Received("x", bytes(size), at_s))
    assert channel.bytes_per_s == pytest.approx(sum(n for _, n in messages[1:]) / sum(s for s, _ in messages[1:]))
    sizes = channel.sizes
    assert (sizes.min_bytes, sizes.max_bytes) == (min(n for _, n in messages), max(n for _, n in messages))
    assert sizes.min_bytes <= sizes.mean_bytes <= sizes.max_bytes


def test_a_live_bandwidth_forgets_after_ten_seconds() -> None:
    now_s = 29.9
    watch = Watch(lambda: now_s)
    for k in range(300):
        channel = watch.receive(Received("x", bytes(1000 if k < 150 else 10), 0.1 * k))
    assert channel.sizes.max_bytes == 10
    assert channel.bytes_per_s == pytest.approx(100)
    now_s = 31.0
    assert channel.bytes_per_s is None, "nothing has come for a second"


def test_bw_of_one_channel(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bw", "CAMERA", str(log)]) == 0
    wanted = "CAMERA  16.4 kB/s, size min: 1.0 kB mean: 8.0 kB max: 15.0 kB window: 3\n"
    assert capsys.readouterr().out == wanted
    assert main(["bw", "once", str(log)]) == 0
    assert capsys.readouterr().out == "once  no rate yet, size min: 10 B mean: 10 B max: 10 B window: 1\n"


@pytest.mark.parametrize("words", [[], ["--for", "1"]])
def test_bw_of_all_channels(log: Path, capsys: pytest.CaptureFixture[str], words: list[str]) -> None:
    assert main(["bw", str(log), *words]) == 0
    rows = [line.split() for line in capsys.readouterr().out.splitlines() if line.strip(" ─")]
    assert rows == [
        ["channel", "bandwidth", "size", "min", "mean", "max", "count", "note"],
        ["CAMERA", "16.4", "kB/s", "1.0", "kB", "8.0", "kB", "15.0", "kB", "3"],
        ["control.twist", "400", "B/s", "40", "B", "40", "B", "40", "B", "21"],
        ["once", "10", "B", "10", "B", "10", "B", "1"],
        ["all", "16.8", "kB/s"],
    ]


SAID_BY = {
    "hz": {"rate_hz", "wall_rate_hz"}
    | {f"{clock}_{name}_s" for clock in ("period", "wall_period") for name in ("min", "max", "std")},
    "bw": {"bytes", "bytes_per_s", "min_bytes", "mean_bytes", "max_bytes"},
}


def said_as_json(capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, Any]:
    """Run a command and return the document that it prints."""
    assert main([*words, "--json"]) == 0
    said: dict[str, Any] = json.loads(capsys.readouterr().out)
    return said


@pytest.mark.parametrize("command", SAID_BY)
def test_programs_are_told_what_spy_tells_them(log: Path, capsys: pytest.CaptureFixture[str], command: str) -> None:
    said = said_as_json(capsys, command, str(log))
    spied = said_as_json(capsys, "spy", str(log))
    assert said["feed"] == str(log)
    assert set(said["channels"]) == set(spied["channels"])
    for name, one in said["channels"].items():
        assert set(one) == SAID_BY[command] | {"type", "messages", "lost", "lost_since_restart", "silent_s"}
        assert one.items() <= spied["channels"][name].items()
    only = said_as_json(capsys, command, "CAMERA", str(log))
    assert only == {"feed": str(log), "dropped_packets": 0, "channels": {"CAMERA": said["channels"]["CAMERA"]}}


@pytest.mark.parametrize("command", SAID_BY)
def test_keys_are_documented(capsys: pytest.CaptureFixture[str], command: str) -> None:
    with pytest.raises(SystemExit):
        main([command, "--help"])
    said = capsys.readouterr().out
    for key in SAID_BY[command]:
        assert key in said or (key.startswith("wall_period") and "wall_period_min_s, ..." in said), key


def test_hz_of_all_channels(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["hz", str(log)]) == 0
    rows = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines() if line.strip(" ─")]
    assert rows[0] == "channel stamp Hz arrival min ms max ms std ms count note"
    assert rows[2:] == ["control.twist 10.00 10.00 100.0 100.0 0.0 21", "once 1"]


@pytest.mark.parametrize("command", ["bw", "hz"])
def test_a_channel_that_is_not_there_is_said(log: Path, capsys: pytest.CaptureFixture[str], command: str) -> None:
    assert main([command, "control.twst", str(log)]) == 2
    assert capsys.readouterr().err == f"{log} has no channel 'control.twst'\n  did you mean 'control.twist'?\n"


@pytest.mark.parametrize("command", ["bw", "hz"])
def test_an_empty_log_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str) -> None:
    (tmp_path / "log").touch()
    assert main([command, str(tmp_path / "log")]) == 1
    assert capsys.readouterr().err == f"{tmp_path / 'log'} is empty\n"


@pytest.mark.parametrize("command", ["bw", "hz", "echo", "spy"])
def test_names_of_channels_are_shown_without_what_a_terminal_obeys(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    name = "\x1b[31mred\x9b"
    with LogWriter(tmp_path / "log") as writer:
        writer.write(name, 0, b"x")
        writer.write(name, 1, b"x")
    words = [name] if command == "echo" else []
    assert main([command, *words, str(tmp_path / "log")]) == 0
    said = capsys.readouterr().out
    assert "\\x1b[31mred\\x9b" in said
    assert not {"\x1b", "\x9b"} & set(said)
    if command == "spy":
        return
    assert main([command, "other", str(tmp_path / "log")]) == 2
    assert capsys.readouterr().err.replace("\n", "").isprintable()


@pytest.fixture
def live(group: str) -> Iterator[str]:
    """Return the group on which commands are published until the test ends."""
    over = threading.Event()

    def publish() -> None:
        bus = Bus(group)
        k = 0
        while not over.wait(0.002):
            bus.publish("x", encode(Twist(0.1, 0.2), 10_000 * k, k))
            k += 1
        bus.close()

    thread = threading.Thread(target=publish)
    thread.start()
    yield group
    over.set()
    thread.join()


@pytest.mark.parametrize("command", ["bw", "hz"])
def test_the_last_report_is_printed_once(live: str, capsys: pytest.CaptureFixture[str], command: str) -> None:
    assert main([command, "x", live, "--for", "1.4"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == (1 if command == "bw" else 2)
    assert main([command, live, "--for", "1.4"]) == 0
    assert capsys.readouterr().out.count("channel") == 1


@pytest.mark.parametrize("command", ["bw", "hz"])
def test_a_live_document_comes_once_and_at_the_end(live: str, capsys: pytest.CaptureFixture[str], command: str) -> None:
    (said,) = said_as_json(capsys, command, "x", live, "--for", "1.4")["channels"].values()
    assert said["messages"] > 1
    assert said["silent_s"] >= 0
    assert said["type"] == "graphnav_lcm.twist_t"


@pytest.mark.parametrize("command", ["hz", "bw"])
@pytest.mark.parametrize("channel", ["x", None])
def test_a_silence_longer_than_the_timeout_ends_it_with_an_error(
    command: str, channel: str | None, group: str, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [command, *filter(None, [channel]), group, "--timeout", "0.3"]
    assert main(words) == 1
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err == f"no message on {group} within 0.3 s\n  start a run: graphnav run GRAPH --pace 1\n"


def test_the_timeout_is_of_the_channel_and_counts_from_its_last_message(
    group: str, capsys: pytest.CaptureFixture[str]
) -> None:
    over = threading.Event()

    def publish() -> None:
        bus, k = Bus(group), 0
        while not over.wait(0.02):
            bus.publish("y", encode(Twist(0.1, 0.2), 20_000 * k, k))
            if k < 25:
                bus.publish("x", encode(Twist(0.1, 0.2), 20_000 * k, k))
            k += 1
        bus.close()

    thread = threading.Thread(target=publish)
    thread.start()
    try:
        assert main(["hz", "x", group, "--timeout", "1.5"]) == 1
        captured = capsys.readouterr()
        assert captured.err == f"no message on channel 'x' of {group} within 1.5 s\n  received: x, y\n"
        assert "average rate: 50" in captured.out
    finally:
        over.set()
        thread.join()


def test_a_log_is_not_waited_for(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["hz", "control.twist", str(log), "--timeout", "0.0001"]) == 0
    assert "average rate: 10.000" in capsys.readouterr().out
