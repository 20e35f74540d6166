"""``graphnav record``: what is received is in the log, complete up to the end, however that comes."""

from __future__ import annotations

import random
import re
import signal
import socket
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from urllib.parse import urlsplit

import lcm
import numpy as np
import pytest

from graphnav.core.bus import Bus
from graphnav.core.cli import main
from graphnav.core.codec import encode
from graphnav.core.messages import About, Image, Status, Stop, Twist
from graphnav.core.record import ChannelFilter, Recording, ThreadedLogWriter
from graphnav.core.run_folder import RunFolder
from graphnav.core.tap import Tap
from graphnav.watch.recorder import ReceiveStatistics, Recorder

from .conftest import TOOLS
from .recording import GRAPHNAV, RecordProcess, events_of, wait_until

DiskOf = Callable[[int], AbstractContextManager[None]]
Start = Callable[..., RecordProcess]
SAID = encode(About("stages: {}\n", "", "cafe", 7, ("twist",), ("graphnav_lcm.twist_t",)), 0, 0)


def twist(k: int) -> bytes:
    """Return the k-th command."""
    return encode(Twist(0.1, 0.2), 1000 * k, k)


@pytest.fixture
def start(group: str) -> Iterator[Start]:
    """Return what starts a process that records; all end with the test."""
    started: list[RecordProcess] = []

    def begin(path: Path, *options: str) -> RecordProcess:
        started.append(RecordProcess(group, path, *options))
        return started[-1]

    yield begin
    for process in started:
        process.close()


def received(path: Path) -> list[tuple[str, bytes]]:
    """Return the recorded messages except marks."""
    return [(event.channel, event.data) for event in events_of(path) if event.channel != "mark"]


def row_of(out: str, channel: str) -> list[str]:
    """Return the words of a channel's row."""
    return next(words for line in out.splitlines() if (words := line.split())[:1] == [channel])


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP], ids=str)
def test_signals_end_it_cleanly(start: Start, tmp_path: Path, number: int) -> None:
    path = tmp_path / "log"
    process = start(path)
    process.publish_until_heard()
    before_us = time.time_ns() // 1000
    sent = [("x", bytes([k])) for k in range(50)]
    for channel, data in sent:
        process.bus.publish(channel, data)
    wait_until(lambda: len(received(path)) == 50)
    status, out, err = process.end(number)
    assert (status, err) == (0, "")
    assert "nothing lost" in out
    assert received(path) == sent
    stamps = [event.utime for event in events_of(path) if event.channel == "x"]
    assert stamps == sorted(stamps)
    assert before_us <= stamps[0] <= stamps[-1] <= time.time_ns() // 1000
    assert subprocess.run([GRAPHNAV, "info", path], capture_output=True, check=True, text=True).stdout.endswith(
        "no damage\n"
    )


def test_kill_9_leaves_complete_events(start: Start, tmp_path: Path) -> None:
    path = tmp_path / "log"
    process = start(path)
    process.publish_until_heard()
    for k in range(200):
        process.bus.publish("x", bytes(1000 + k))
    wait_until(lambda: len(received(path)) == 200)
    process.process.kill()
    process.process.wait()
    with Recording(path) as recording:
        assert (recording.truncated, recording.damaged) == (None, [])
    assert [len(data) for _, data in received(path)] == [1000 + k for k in range(200)]


def test_the_log_describes_itself_first(start: Start, tmp_path: Path, group: str) -> None:
    path = tmp_path / "log"
    process = start(path, "-c", "twist")
    for k in range(30):
        process.bus.publish("twist", twist(k))
        process.bus.publish("other", b"")
        if k == 20:
            process.bus.publish(About.CHANNEL, SAID)
    wait_until(lambda: len(received(path)) >= 31)
    status, out, _ = process.end()
    assert status == 0
    events = events_of(path)
    assert (events[0].channel, events[0].data) == (About.CHANNEL, SAID)
    assert events[0].utime == events[1].utime
    assert [event.data for event in events[1:]] == [twist(k) for k in range(30)]
    assert row_of(out, "twist")[:3] == ["twist", "graphnav_lcm.twist_t", "30"]


def test_losses_are_told(start: Start, tmp_path: Path) -> None:
    process = start(tmp_path / "log")
    process.publish_until_heard()
    for k in (5, 6, 9, 10):
        process.bus.publish("twist", twist(k))
    wait_until(lambda: len(received(tmp_path / "log")) == 4)
    status, out, _ = process.end()
    assert status == 0
    assert "2 messages lost (missing sequence numbers)\n" in out
    assert row_of(out, "twist") == ["twist", "graphnav_lcm.twist_t", "4", "160", "B", "2"]


def test_what_a_tap_leaves_out_is_told_apart(start: Start, tmp_path: Path, group: str) -> None:
    path = tmp_path / "log"
    process = start(path)
    process.publish_until_heard()
    tap, image = Tap("thin", "cafe", group), Image(pixels=np.zeros((60, 80), np.uint8))
    sent = left_out = 0
    while sent < 200 or tap.dropped > left_out:  # the last one is sent: a gap has two ends
        left_out = tap.dropped
        tap.write("robot.image", sent, encode(image, sent, sent))
        sent += 1
    tap.write(Status.CHANNEL, sent, encode(status_of("cafe", left_out), sent, 0))
    wait_until(lambda: len(received(path)) == sent + 1 - left_out)
    tap.close()
    status, out, _ = process.end()
    assert status == 0
    assert left_out > 0
    assert f"{left_out:,} messages lost (missing sequence numbers), at least {left_out:,} of them left out by" in out


def status_of(run_id: str, tap_dropped: int) -> Status:
    """Return a status of a run in lockstep."""
    return Status(run_id, "g", False, 1.0, 1.0, 0.0, 1.0, tap_dropped, 0, "", (), (), (), ())


def test_what_a_suspended_process_loses_is_told(start: Start, tmp_path: Path) -> None:
    path = tmp_path / "log"
    process = start(path)
    sent = 0

    def publish() -> None:
        nonlocal sent
        process.bus.publish("stop", encode(Stop(engaged=True, reason="x" * 50_000), 0, sent))
        sent += 1

    process.publish_until_heard()
    publish()
    process.process.send_signal(signal.SIGSTOP)
    for _ in range(400):  # 20 MB, and 4 MB fit the receive buffer
        publish()
    process.process.send_signal(signal.SIGCONT)
    last = sent

    def is_heard() -> bool:
        publish()
        return any(data[16:24] >= last.to_bytes(8, "big") for channel, data in received(path) if channel == "stop")

    wait_until(is_heard)
    _, out, _ = process.end()
    seqs = [int.from_bytes(data[16:24], "big") for channel, data in received(path) if channel == "stop"]
    lost = seqs[-1] + 1 - len(seqs)
    assert lost > 0
    assert row_of(out, "stop")[-1] == str(lost)
    assert re.search(
        rf"; {lost} messages? lost \(missing sequence numbers\); [1-9]\d* packets? dropped by the kernel\n", out
    )


def test_packets_that_no_program_should_send_do_no_harm(start: Start, tmp_path: Path, group: str) -> None:
    process = start(tmp_path / "log")
    process.publish_until_heard()
    parts = urlsplit(group)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
        rng = random.Random(5)
        for packet in (
            *(rng.randbytes(rng.randrange(100)) for _ in range(200)),
            *(b"LC02\0\0\0\0" + name + b"\0data" for name in (b"", b"\xff\xfe", "fl\u00fcgel".encode(), b"x")),
        ):
            sender.sendto(packet, (parts.hostname or "", parts.port or 0))
    wait_until(lambda: ("x", b"data") in received(tmp_path / "log"))
    _, out, err = process.end()
    assert err == ""
    assert received(tmp_path / "log") == [("fl\u00fcgel", b"data"), ("x", b"data")]
    assert "1 message on a channel without a name\n" in out
    with Recording(tmp_path / "log") as recording:
        assert (recording.truncated, recording.damaged) == (None, [])


def test_names_are_shown_as_text(start: Start, tmp_path: Path) -> None:
    process = start(tmp_path / "log")
    process.publish_until_heard()
    process.bus.publish("\x1b[31m[red]", b"12345678")
    wait_until(lambda: len(received(tmp_path / "log")) == 1)
    _, out, _ = process.end()
    assert row_of(out, r"\x1b[31m[red]")[1:4] == ["unknown,", "3132333435363738", "1"]
    assert "\x1b" not in out


def test_it_ends_by_itself_and_says_that_nothing_came(
    tmp_path: Path, group: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "log"
    assert main(["record", group, "-o", str(path), "--for", "0.2"]) == 0
    url = f"{group}&recv_buf_size=2097152"
    assert capsys.readouterr().out == (
        f"recording to {path}; Ctrl-C ends it\n  from {url}\n"
        f"no message on {url}\n0 messages, 0 B; nothing lost\n{path}: 0 B\n"
    )
    assert path.stat().st_size == 0


def test_images_are_kept(start: Start, tmp_path: Path) -> None:
    path = tmp_path / "log"
    process = start(path, "-c", "image")
    rng = np.random.default_rng(1)
    sent = []
    for k in range(12):
        sent.append(encode(Image(rng.integers(0, 255, (480, 640), np.uint8)), k, k))
        process.bus.publish("image", sent[-1])
        if k % 4 == 3:  # more would not fit the receive buffer at once
            wait_until(lambda n=k + 1: len(received(path)) == n)  # type: ignore[misc]
    process.end()
    assert [data for _, data in received(path)] == sent


def test_lcm_logplayer_plays_what_was_recorded(start: Start, tmp_path: Path, group: str) -> None:
    path = tmp_path / "log"
    process = start(path, "-c", "twist")
    sent = [twist(k) for k in range(40)]
    for data in sent:
        process.bus.publish("twist", data)
    wait_until(lambda: len(received(path)) == 40)
    process.end()
    listener = lcm.LCM(group)
    played: list[bytes] = []
    listener.subscribe("twist", lambda _, data: played.append(data)).set_queue_capacity(0)
    player = subprocess.Popen([TOOLS / "lcm-logplayer", "--lcm-url", group, path], stdout=subprocess.DEVNULL)
    while len(played) < 40 and listener.handle_timeout(10_000):
        pass
    assert player.wait(30) == 0
    assert played == sent


def test_files_are_split_and_rotated(start: Start, tmp_path: Path) -> None:
    process = start(tmp_path / "drive.lcmlog", "--split", "10kB", "--rotate", "3")
    process.bus.publish(About.CHANNEL, SAID)
    for k in range(100):
        process.bus.publish("x", bytes(1000))
        if k % 10 == 9:
            wait_until(lambda k=k: _newest(tmp_path) >= k // 10)  # type: ignore[misc]
    status, out, _ = process.end()
    assert status == 0
    files = sorted(tmp_path.iterdir())
    assert len(files) == 3
    assert all(events_of(file)[0].channel == About.CHANNEL for file in files)
    assert f"{files[0]} to {files[-1].name} (3 files): " in out


def _newest(folder: Path) -> int:
    return max(int(file.stem.rpartition(".")[2]) for file in folder.iterdir())


def test_a_full_disk_is_told_at_once_and_recording_goes_on_when_there_is_room(
    tmp_path: Path, group: str, capfd: pytest.CaptureFixture[str], disk_of: DiskOf
) -> None:
    path, bus = tmp_path / "log", Bus(group)
    notices: list[str] = []

    def publish_until_told(n_notices: int) -> None:
        while len(notices) < n_notices:
            bus.publish("x", bytes(50_000))
            time.sleep(0.001)

    with disk_of(1_000_000):
        recorder = Recorder(group, path, ChannelFilter(), notice=notices.append)
        recorder.start()
        publish_until_told(1)
    publish_until_told(2)
    recorder.close()
    bus.close()
    assert notices[0] == (
        f"{path}: File too large; the log holds 19 complete events; messages are dropped until the disk takes them"
    )
    assert re.fullmatch(rf"{path}: recording again; {recorder.dropped} messages of [0-9.]+ s are missing", notices[1])
    assert recorder.failure == ""
    with Recording(path) as recording:
        assert (recording.truncated, recording.damaged) == (None, [])
        channels = [event.channel for event in recording.events()]
    assert channels.index("graphnav.gap") == 19
    assert channels.count("graphnav.gap") == 1
    assert len(channels) > 20


def test_a_full_disk_is_a_failure(group: str, capsys: pytest.CaptureFixture[str]) -> None:
    is_over = threading.Event()

    def publish() -> None:
        bus = Bus(group)
        while not is_over.wait(0.01):
            bus.publish("TWIST", twist(0))
        bus.close()

    thread = threading.Thread(target=publish)
    thread.start()
    try:
        assert main(["record", group, "-o", "/dev/full", "--force", "--for", "2"]) == 1
    finally:
        is_over.set()
        thread.join()
    out, err = capsys.readouterr()
    failure = "/dev/full: No space left on device; the log holds 0 complete events"
    assert err == f"{failure}; messages are dropped until the disk takes them\n{failure}\n"
    assert "messages not written" in out


def test_an_existing_log_is_kept_unless_it_is_to_be_replaced(
    tmp_path: Path, group: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "log"
    path.write_text("precious")
    assert main(["record", group, "-o", str(path), "--for", "0.1"]) == 2
    assert capsys.readouterr().err == (
        f"-o: {path} already exists\n  name another file with -o, or replace it with --force\n"
    )
    assert path.read_text() == "precious"
    assert main(["record", group, "-o", str(path), "--for", "0.1", "--force"]) == 0
    assert path.read_text() == ""


def test_parts_of_an_older_recording_are_kept_unless_they_are_to_be_replaced(
    tmp_path: Path, group: str, capsys: pytest.CaptureFixture[str]
) -> None:
    old = tmp_path / "drive.0007.lcmlog"
    old.write_text("precious")
    words = ["record", group, "-o", str(tmp_path / "drive.lcmlog"), "--split", "1MB", "--for", "0.1"]
    assert main(words) == 2
    assert capsys.readouterr().err.startswith(f"-o: {old} already exists\n")
    assert main([*words, "--force"]) == 0
    assert [path.name for path in tmp_path.iterdir()] == ["drive.0000.lcmlog"]


def test_later_parts_of_a_run_are_not_read_as_those_of_a_new_log(
    tmp_path: Path, group: str, capsys: pytest.CaptureFixture[str]
) -> None:
    old = tmp_path / "run.0001.lcmlog"
    old.write_text("precious")
    words = ["record", group, "-o", str(tmp_path / RunFolder.LOG), "--for", "0.1"]
    assert main(words) == 2
    assert capsys.readouterr().err.startswith(f"-o: {old} already exists\n")
    assert main([*words, "--force"]) == 0
    assert [path.name for path in tmp_path.iterdir()] == [RunFolder.LOG]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ["tcpq://localhost"],
            f"FEED: 'tcpq://localhost' is not a udpm:// URL\n  write {Bus.GROUP}, or another group of 239.0.0.0/8\n",
        ),
        (
            ["udpm://127.0.0.1:7667"],
            f"FEED: '127.0.0.1' is not a multicast address\n  write {Bus.GROUP}, or another group of 239.0.0.0/8\n",
        ),
        (["--rotate", "3"], "--rotate: only one file is written\n  add --split SIZE, or remove it\n"),
        (["--invert"], "--invert: there is no filter to invert\n  add --channel GLOB or --regex RE\n"),
        (
            ["--regex", "["],
            (
                "--regex: '[' is not a regular expression: unterminated character set at position 0\n"
                "  escape special characters with a backslash\n"
            ),
        ),
        (["-o", "{tmp}/none/log"], "-o: cannot write {tmp}/none/log: No such file or directory\n  name another file\n"),
        (["-o", "{tmp}"], "-o: {tmp} already exists\n  name another file with -o, or replace it with --force\n"),
        (["-o", "{tmp}", "--force"], "-o: cannot write {tmp}: Is a directory\n  name another file\n"),
    ],
)
def test_a_command_line_that_is_wrong_is_refused(
    tmp_path: Path,
    group: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    words: list[str],
    said: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    url = [] if words[0].endswith(("localhost", "7667")) else [group]
    assert main(["record", *url, "--for", "0.1", *(word.format(tmp=tmp_path) for word in words)]) == 2
    assert capsys.readouterr().err == said.format(tmp=tmp_path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--split", "often"], "argument --split: 'often' is not a size or time: write 100MB or 60s"),
        (["--quota", "5"], "argument --quota: '5' is not a size: write 100MB or 2GiB"),
        (["--for", "nan"], "argument --for: 'nan' is not a number of seconds above 0"),
        (["--rotate", "0"], "argument --rotate: '0' is not an integer above 0"),
    ],
)
def test_an_argument_that_is_wrong_is_refused(capsys: pytest.CaptureFixture[str], words: list[str], said: str) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["record", *words])
    assert said in capsys.readouterr().err


def test_a_disk_with_less_than_the_quota_is_told_at_once(
    tmp_path: Path, group: str, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "log"
    assert main(["record", group, "-o", str(log), "--quota", "1000000TB", "--for", "60"]) == 1
    assert "bytes are free on its disk, less than --quota requires" in capsys.readouterr().err
    assert not log.exists()


def test_channels_without_number_do_not_fill_the_memory() -> None:
    statistics = ReceiveStatistics()
    for k in range(12_000):
        statistics.receive(f"channel {k}", twist(k), 0.0)
    assert len(statistics.channels) == 10_000
    assert statistics.others.count == 2000
    assert (statistics.n_messages, statistics.n_bytes, statistics.lost) == (12_000, 12_000 * 40, 0)


def test_a_listener_does_not_wait_for_the_disk(tmp_path: Path, group: str) -> None:
    """A disk that hangs costs messages, which are counted; it never holds up the listening thread."""
    log = ThreadedLogWriter(tmp_path / "log", max_bytes=1000)
    for _ in range(100):
        log.write("x", 0, bytes(900))
    log.close()
    assert log.dropped + log.n_events == 100
