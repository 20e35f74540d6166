"""A recording in one file or several: each describes itself, the newest are kept, and the disk is not filled up."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import pytest

from graphnav.core.codec import decode, encode
from graphnav.core.errors import LogError
from graphnav.core.messages import About
from graphnav.core.record import Recording
from graphnav.core.record.about_first import WAIT_S, AboutFirst
from graphnav.core.record.log_files import LogFiles, Split
from graphnav.core.record.log_paths import files_of, numbered, parts_of
from graphnav.core.run_folder import RunFolder

DiskOf = Callable[[int], AbstractContextManager[None]]
SAID = encode(About("stages: {}\n", "", "cafe", 7, (), ()), 0, 0)


def events(path: Path) -> list[tuple[str, int]]:
    """Return the channels and stamps of a log."""
    with Recording(path) as recording:
        assert (recording.truncated, recording.damaged) == (None, [])
        return [(event.channel, event.utime) for event in recording.events()]


def fill(log: LogFiles) -> None:
    """Write half a megabyte."""
    for k in range(500):
        log.write("x", k, bytes(1000))


def test_without_a_split_there_is_one_file(tmp_path: Path) -> None:
    log = LogFiles(tmp_path / "log")
    for k in range(10):
        log.write("x", k, b"12345")
    log.close()
    assert log.paths == [tmp_path / "log"]
    assert events(tmp_path / "log") == [("x", k) for k in range(10)]


def test_files_are_split_by_size(tmp_path: Path) -> None:
    log = LogFiles(tmp_path / "drive.lcmlog", Split(n_bytes=1000))
    for k in range(50):
        log.write("x", k, bytes(71))  # 100 bytes with the header
    log.close()
    assert [path.name for path in log.paths] == [f"drive.{k:04}.lcmlog" for k in range(5)]
    assert [path.stat().st_size for path in log.paths] == [1000] * 5
    assert sum(map(events, log.paths), start=list[tuple[str, int]]()) == [("x", k) for k in range(50)]
    assert (log.n_events, log.n_bytes) == (50, 5000)


def test_files_are_split_by_time(tmp_path: Path) -> None:
    log = LogFiles(tmp_path / "log", Split(us=1000))
    for k in (0, 999, 1000, 1500, 5000):
        log.write("x", k, b"")
    log.close()
    assert [events(path) for path in log.paths] == [
        [("x", 0), ("x", 999)],
        [("x", 1000), ("x", 1500)],
        [("x", 5000)],
    ]


def test_an_event_that_is_larger_than_a_file_has_one_of_its_own(tmp_path: Path) -> None:
    log = LogFiles(tmp_path / "log", Split(n_bytes=100))
    log.write(About.CHANNEL, 0, SAID)
    for k in range(3):
        log.write("x", k, bytes(1000))
    log.close()
    assert [events(path) for path in log.paths] == [
        [(About.CHANNEL, 0)],
        *([(About.CHANNEL, k), ("x", k)] for k in range(3)),
    ]


def test_each_file_describes_itself(tmp_path: Path) -> None:
    log = LogFiles(tmp_path / "log", Split(us=10))
    log.write("x", 0, b"")
    log.write(About.CHANNEL, 5, SAID)
    log.write("x", 12, b"")
    log.write(About.CHANNEL, 22, SAID)
    log.write(About.CHANNEL, 23, b"not a description")
    log.write("x", 40, b"")
    log.close()
    assert [events(path) for path in log.paths] == [
        [("x", 0), (About.CHANNEL, 5)],
        [(About.CHANNEL, 12), ("x", 12)],
        [(About.CHANNEL, 22), (About.CHANNEL, 23)],
        [(About.CHANNEL, 40), ("x", 40)],
    ]
    assert log.n_events == 6, "copies are not counted"


def test_the_newest_files_are_kept(tmp_path: Path) -> None:
    log = LogFiles(tmp_path / "log", Split(us=10), rotate=2)
    for k in range(6):
        log.write("x", 10 * k, b"")
    log.close()
    assert [path.name for path in log.paths] == ["log.0004", "log.0005"]
    assert files_of(tmp_path / "log") == log.paths
    assert log.n_events == 6


def test_a_disk_that_is_nearly_full_ends_it(tmp_path: Path) -> None:
    free = iter([10_000_000, 999])
    log = LogFiles(tmp_path / "log", free_quota_bytes=1000, free_bytes=lambda _: next(free, 999))
    with pytest.raises(LogError, match="999 bytes are free on its disk, less than --quota requires"):
        fill(log)
    log.close()
    assert log.n_bytes < 300_000, "it looks again when so much was written, however fast"


def test_a_disk_that_is_nearly_full_from_the_beginning_gets_no_file(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="999 bytes are free on its disk, less than --quota requires"):
        LogFiles(tmp_path / "log", free_quota_bytes=1000, free_bytes=lambda _: 999)
    assert list(tmp_path.iterdir()) == []


def test_a_full_disk_is_an_error_and_the_log_is_complete(tmp_path: Path, disk_of: DiskOf) -> None:
    with disk_of(10_000):
        log = LogFiles(tmp_path / "log", Split(n_bytes=50_000))
        with pytest.raises(LogError, match="File too large; the log holds 9 complete events"):
            fill(log)
        log.close()
    assert log.n_events == len(events(log.paths[0])) == 9


def test_only_parts_of_the_same_recording_are_found(tmp_path: Path) -> None:
    for name in ("a.0000.lcmlog", "a.0001.lcmlog", "a.lcmlog", "a.1.lcmlog", "a.x000.lcmlog", "b.0000.lcmlog"):
        (tmp_path / name).touch()
    assert [path.name for path in files_of(tmp_path / "a.lcmlog")] == ["a.0000.lcmlog", "a.0001.lcmlog"]
    assert numbered(Path("x/drive"), 12) == Path("x/drive.0012")


def test_parts_are_in_the_order_of_their_numbers(tmp_path: Path) -> None:
    log = tmp_path / RunFolder.LOG
    parts = [log, *(numbered(log, number) for number in (1, 9999, 10_000, 10_001, 100_000))]
    for part in parts:
        part.touch()
    assert parts_of(log) == parts


class Time:
    """A clock that is set."""

    now_s = 0.0

    def __call__(self) -> float:
        """Return the time."""
        return self.now_s


def test_the_description_comes_first_with_the_first_stamp(tmp_path: Path) -> None:
    log = AboutFirst(LogFiles(tmp_path / "log"), Time())
    log.write("x", 10, b"a")
    log.write("x", 20, b"b")
    assert (log.n_events, log.n_bytes) == (2, 0), "they are held back"
    log.write(About.CHANNEL, 30, SAID)
    log.write(About.CHANNEL, 40, SAID)
    log.close()
    assert events(tmp_path / "log") == [(About.CHANNEL, 10), ("x", 10), ("x", 20), (About.CHANNEL, 40)]


@pytest.mark.parametrize("how", ["write", "flush", "close", "much"])
def test_without_a_description_nothing_is_invented(tmp_path: Path, how: str) -> None:
    time = Time()
    log = AboutFirst(LogFiles(tmp_path / "log"), time)
    log.write("x", 10, bytes(40 << 20) if how == "much" else b"a")
    log.write(About.CHANNEL, 15, b"not a description")
    log.flush()
    assert (log.n_bytes > 0) == (how == "much")
    time.now_s = WAIT_S
    if how == "write":
        log.write("x", 20, b"b")
        assert log.n_bytes > 0
    elif how == "flush":
        log.flush()
        assert len(events(tmp_path / "log")) == 2
    log.write(About.CHANNEL, 30, SAID)
    log.close()
    assert [utime for _, utime in events(tmp_path / "log")] == [10, 15, *([20] if how == "write" else []), 30]


@pytest.mark.parametrize("has_run", [False, True])
def test_given_definitions_are_part_of_every_description(tmp_path: Path, *, has_run: bool) -> None:
    text = "package no_such_package;\n\nstruct given_t\n{\n    int32_t n;\n}\n"
    log = AboutFirst(LogFiles(tmp_path / "log", Split(n_bytes=1000)), Time(), text)
    for k in range(20):
        log.write("x", k, bytes(200))
        if has_run:
            log.write(About.CHANNEL, k, SAID)
    log.write(About.CHANNEL, 20, b"not a description")
    assert log.n_events == 21 + 20 * has_run
    log.close()
    parts = files_of(tmp_path / "log")
    assert len(parts) > 4
    for part in parts:
        with Recording(part) as recording:
            first = next(recording.events())
            assert first.channel == About.CHANNEL
            about = decode(About, first.data)[2]
            assert text in about.lcm_text
            assert (recording.about is not None) == has_run
            assert bool(about.graph_yaml) == has_run
