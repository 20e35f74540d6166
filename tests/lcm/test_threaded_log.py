"""A log that is written by a thread: the caller never waits, losses are counted, the rest is complete."""

from __future__ import annotations

import os
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path

import pytest

from graphnav.core.codec import encode
from graphnav.core.messages import About, Gap
from graphnav.core.record import LogGap, LogWriter, Recording, ThreadedLogWriter, threaded_writer
from graphnav.core.record.log_files import LogFiles, Split
from graphnav.core.record.log_paths import files_of, numbered
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner.recording.kept_messages import open_log
from graphnav.core.spec import RunOptions

DiskOf = Callable[[int], AbstractContextManager[None]]

PATIENCE_S = 60


class SlowDisk(LogWriter):
    """A log whose disk takes nothing until it is told to."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self.is_asked = threading.Event()
        self.goes_on = threading.Event()

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Wait, then write."""
        self.is_asked.set()
        assert self.goes_on.wait(PATIENCE_S)
        super().write(channel, utime, data)


@pytest.fixture
def slow_disks() -> Iterator[list[SlowDisk]]:
    """Return the slow disks that the test opened; they go on when it ends."""
    opened: list[SlowDisk] = []
    yield opened
    for disk in opened:
        disk.goes_on.set()


def opener(opened: list[SlowDisk]) -> Callable[[Path], LogWriter]:
    """Return what opens a slow disk and keeps it."""

    def open_log(path: Path) -> LogWriter:
        opened.append(SlowDisk(path))
        return opened[-1]

    return open_log


def wait_until(is_so: Callable[[], bool]) -> None:
    """Wait for a condition."""
    end_s = time.monotonic() + PATIENCE_S
    while not is_so():
        assert time.monotonic() < end_s
        time.sleep(0.005)


def test_everything_is_written_in_order(tmp_path: Path) -> None:
    log = ThreadedLogWriter(tmp_path / "log")
    for k in range(5000):
        log.write("x", k, bytes(k % 300))
    log.close()
    log.close()
    assert (log.dropped, log.failure, log.n_events) == (0, "", 5000)
    assert log.n_bytes == (tmp_path / "log").stat().st_size
    with Recording(tmp_path / "log") as recording:
        assert [(event.utime, len(event.data)) for event in recording.events()] == [(k, k % 300) for k in range(5000)]


def test_what_was_written_is_flushed_while_nothing_comes(tmp_path: Path) -> None:
    log = ThreadedLogWriter(tmp_path / "log")
    log.write("x", 1, b"abc")
    wait_until(lambda: (tmp_path / "log").stat().st_size == 28 + 1 + 3)
    log.close()


def test_a_slow_disk_holds_up_no_writer_and_what_overflows_is_dropped(
    tmp_path: Path, slow_disks: list[SlowDisk]
) -> None:
    log = ThreadedLogWriter(tmp_path / "log", max_bytes=10 * 1200, open_log=opener(slow_disks))
    for k in range(50):
        log.write("x", k, bytes(1000))
    assert log.dropped == 40
    slow_disks[0].goes_on.set()
    log.close()
    assert (log.dropped, log.failure) == (40, "")
    with Recording(tmp_path / "log") as recording:
        assert recording.utimes("x") == list(range(10))
        assert recording.truncated is None


def test_after_an_overflow_the_recording_goes_on(tmp_path: Path, slow_disks: list[SlowDisk]) -> None:
    log = ThreadedLogWriter(tmp_path / "log", max_bytes=2 * 1200, open_log=opener(slow_disks))
    for k in range(3):
        log.write("x", k, bytes(1000))
    slow_disks[0].goes_on.set()
    wait_until(lambda: log.n_events == 2)
    log.write("x", 7, bytes(2300))
    log.write("x", 8, b"")
    log.close()
    with Recording(tmp_path / "log") as recording:
        assert recording.utimes("x") == [0, 1, 8]
    assert log.dropped == 2


def test_a_disk_that_hangs_ends_the_recording_when_it_is_closed(tmp_path: Path, slow_disks: list[SlowDisk]) -> None:
    notices: list[str] = []
    log = ThreadedLogWriter(tmp_path / "log", notice=notices.append, open_log=opener(slow_disks))
    for k in range(3):
        log.write("x", k, b"")
    assert slow_disks[0].is_asked.wait(PATIENCE_S)
    log.close(timeout_s=0.01)
    assert log.failure == f"{tmp_path / 'log'}: the last events were not written within 0.01 s"
    assert notices == [log.failure]
    assert log.dropped == 3


@pytest.mark.parametrize("n_bytes", [97 * 1029, 97 * 1029 + 17, 971 * 1029 + 50])
def test_a_full_disk_ends_the_recording_and_not_the_caller(disk_of: DiskOf, tmp_path: Path, n_bytes: int) -> None:
    notices: list[str] = []
    with disk_of(n_bytes):
        log = ThreadedLogWriter(tmp_path / "log", notice=notices.append)
        for k in range(3000):
            log.write("x", k, bytes(1000))
        wait_until(lambda: bool(notices))
        assert log.failure == "", "there may be room again"
        log.write("x", 3000, b"")
        log.close()
    kept = n_bytes // 1029
    assert log.failure.endswith(f"File too large; the log holds {kept} complete events")
    assert notices == [f"{log.failure}; messages are dropped until the disk takes them", log.failure]
    assert (log.n_events, log.dropped, log.gaps) == (kept, 3001 - kept, [])
    assert log.n_bytes == (tmp_path / "log").stat().st_size == kept * 1029
    with Recording(tmp_path / "log") as recording:
        assert recording.truncated is None
        assert recording.utimes("x") == list(range(kept))


@pytest.mark.parametrize("n_parts", [0, 1])
def test_once_the_disk_has_room_the_recording_goes_on_and_tells_the_gap(
    disk_of: DiskOf, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, n_parts: int
) -> None:
    monkeypatch.setattr(threaded_writer, "_RETRY_S", 0.0)
    notices: list[str] = []

    def open_files(path: Path) -> LogFiles:
        return LogFiles(path, Split(n_bytes=50_000) if n_parts else None)

    with disk_of(20_000):
        log = ThreadedLogWriter(tmp_path / "log", notice=notices.append, open_log=open_files)
        for k in range(30):
            log.write("x", 10 + k, bytes(1000))
        wait_until(lambda: log.dropped == 30 - 20_000 // 1029)
    for k in range(30, 60):
        log.write("x", 10 + k, bytes(1000))
    log.close()
    kept = [*range(19), *range(30, 60)]
    assert (log.failure, log.dropped, log.gaps) == ("", 11, [LogGap(28, 40, 11)])
    first = numbered(tmp_path / "log", 0) if n_parts else tmp_path / "log"
    found = []
    for path in files_of(tmp_path / "log") or [first]:
        with Recording(path) as recording:
            assert (recording.truncated, recording.damaged) == (None, [])
            found += [event.utime - 10 for event in recording.events() if event.channel == "x"]
            gaps = list(recording.messages(Gap.CHANNEL))
            if path == first:
                stamp, _, gap = gaps[0]
                assert isinstance(gap, Gap)
                assert (stamp, gap.from_us, gap.n_messages) == (40, 28, 11)
                assert gap.reason in notices[0]
            else:
                assert gaps == []
    assert found == kept
    assert notices[1] == f"{tmp_path / 'log'}: recording again; 11 messages of 0.0 s are missing"


@pytest.mark.parametrize("rotate_s", [None, 60.0])
def test_a_log_that_lost_its_description_gets_it_again(
    disk_of: DiskOf, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rotate_s: float | None
) -> None:
    monkeypatch.setattr(threaded_writer, "_RETRY_S", 0.0)
    about = About("stages: {}", "", run_id="", seed=7, channels=("x",), types=("graphnav_lcm.twist_t",))
    with disk_of(10):
        log = ThreadedLogWriter(tmp_path / RunFolder.LOG, open_log=partial(open_log, RunOptions(rotate_s=rotate_s)))
        log.write(About.CHANNEL, 5, encode(about, 5, 0))
        for k in range(30):
            log.write("x", 10 + k, bytes(1000))
        wait_until(lambda: log.dropped == 31)
    log.write("x", 50, bytes(1000))
    log.close()
    assert (log.failure, log.dropped, log.gaps) == ("", 31, [LogGap(5, 50, 31)])
    with Recording(tmp_path / RunFolder.LOG) as recording:
        assert recording.about is not None
        assert recording.about.graph_yaml == about.graph_yaml
        assert [(event.channel, event.utime) for event in recording.events()] == [
            (About.CHANNEL, 5),
            (Gap.CHANNEL, 50),
            ("x", 50),
        ]


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """Return a disk of 4 MB; skip where none can be mounted."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=4m", "graphnav", folder], check=False, capture_output=True
    )
    if mounted.returncode != 0:
        pytest.skip(f"cannot mount a tmpfs: {mounted.stderr.decode()}")
    try:
        yield folder
    finally:
        subprocess.run(["umount", folder], check=True)


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root mounts a disk")
def test_a_few_free_bytes_do_not_resume_a_recording(small_disk: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(threaded_writer, "_RETRY_S", 0.0)
    notices: list[str] = []
    path = small_disk / "run.lcmlog"
    fill = small_disk / "fill"
    fill.write_bytes(bytes(3 << 20))
    log = ThreadedLogWriter(path, notice=notices.append)
    for k in range(2000):
        log.write("x", k, bytes(1000))
    wait_until(lambda: log.fault != "")
    assert log.fault == "No space left on device"
    with fill.open("r+b") as file:
        file.truncate((3 << 20) - 100_000)
    n_events = log.n_events
    n_given = 2000

    def is_taken() -> bool:
        return log.n_events - len(log.gaps) + log.dropped == n_given

    while n_given < 2010:
        log.write("x", n_given, bytes(1000))
        n_given += 1
        wait_until(is_taken)
    assert (log.n_events, log.gaps, len(notices)) == (n_events, [], 1)
    fill.unlink()
    while log.fault:
        log.write("x", n_given, bytes(1000))
        n_given += 1
        wait_until(is_taken)
    log.close()
    assert (log.failure, len(log.gaps), len(notices)) == ("", 1, 2)
    with Recording(path) as recording:
        assert (recording.truncated, recording.damaged) == (None, [])
        (gap,) = (message for _, _, message in recording.messages(Gap.CHANNEL))
        assert isinstance(gap, Gap)
        assert gap.reason == "No space left on device"
        assert len(recording.utimes("x")) + gap.n_messages == n_given


def test_a_disk_that_is_full_from_the_start_is_told_when_it_is_closed() -> None:
    notices: list[str] = []
    log = ThreadedLogWriter("/dev/full", notice=notices.append)
    log.write("x", 0, b"")
    log.close()
    assert notices == ["/dev/full: No space left on device; the log holds 0 complete events"]
    assert (log.n_events, log.dropped) == (0, 1)


def test_after_closing_events_are_dropped(tmp_path: Path) -> None:
    log = ThreadedLogWriter(tmp_path / "log")
    log.close()
    log.write("x", 0, b"")
    assert (log.n_events, log.dropped) == (0, 1)


def test_a_folder_that_is_missing_is_an_error_at_once(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        ThreadedLogWriter(tmp_path / "none" / "log")
