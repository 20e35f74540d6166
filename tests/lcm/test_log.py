"""Logs are compatible with LCM's own tools in both directions, and complete after any failure."""

from __future__ import annotations

import itertools
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path

import lcm
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graphnav.core.codec import encode, lcm_text_of
from graphnav.core.errors import LogError
from graphnav.core.messages import About, Flow, Twist
from graphnav.core.record import LogWriter, Recording

DiskOf = Callable[[int], AbstractContextManager[None]]

GRAPH = "stages: {robot: {use: world.pymunk}}\n"
SAID = About(
    graph_yaml=GRAPH,
    lcm_text=lcm_text_of([Twist.lcm_class]),
    run_id="",
    seed=7,
    channels=("control.twist",),
    types=("graphnav_lcm.twist_t",),
)
TWISTS = [Twist(v_mps=0.1 * k, omega_radps=-0.2 * k) for k in range(5)]


def write_log(path: Path) -> Path:
    """Write what a short run would."""
    with LogWriter(path) as log:
        log.write(About.CHANNEL, 0, encode(SAID, 0, 0))
        for k, twist in enumerate(TWISTS):
            log.write("control.twist", 100_000 * k, encode(twist, 100_000 * k, k))
    return path


events = st.lists(
    st.tuples(
        st.text(st.characters(codec="ascii", min_codepoint=33), min_size=1, max_size=63),
        st.integers(0, 2**62),
        st.binary(max_size=300),
    ),
    max_size=20,
)


@settings(derandomize=True, deadline=None, max_examples=40)
@given(wanted=events)
def test_lcm_reads_our_log_and_we_read_lcms(
    tmp_path_factory: pytest.TempPathFactory, wanted: list[tuple[str, int, bytes]]
) -> None:
    folder = tmp_path_factory.mktemp("logs")
    with LogWriter(folder / "ours") as log:
        for channel, utime, data in wanted:
            log.write(channel, utime, data)
    theirs = lcm.EventLog(str(folder / "theirs"), "w")
    for channel, utime, data in wanted:
        theirs.write_event(utime, channel, data)
    theirs.close()

    assert (folder / "ours").read_bytes() == (folder / "theirs").read_bytes()
    with Recording(folder / "theirs") as recording:
        assert [tuple(event) for event in recording.events()] == wanted
    if wanted:
        read = [(e.channel, e.timestamp, e.data) for e in lcm.EventLog(str(folder / "ours"))]
        assert read == wanted


def test_a_recording_tells_what_it_holds(tmp_path: Path) -> None:
    with Recording(write_log(tmp_path / "run.lcmlog")) as recording:
        assert recording.about == recording.about
        assert recording.about is not None
        assert recording.about.seed == 7
        assert recording.graph == {"stages": {"robot": {"use": "world.pymunk"}}}
        assert recording.channels == {About.CHANNEL: About.lcm_class, "control.twist": Twist.lcm_class}
        assert recording.n_events == 6
        assert recording.utimes("control.twist") == [0, 100_000, 200_000, 300_000, 400_000]
        assert recording.truncated is None


def test_messages_come_in_order_and_by_index(tmp_path: Path) -> None:
    with Recording(write_log(tmp_path / "run.lcmlog")) as recording:
        read = list(recording.messages("control.twist"))
        assert [(utime, seq) for utime, seq, _ in read] == [(100_000 * k, k) for k in range(5)]
        assert [vars(message) for _, _, message in read] == [vars(twist) for twist in TWISTS]
        assert vars(recording.message("control.twist", -1)[2]) == vars(TWISTS[-1])
        assert recording.fields("control.twist", 2)["seq"] == 2
        assert list(recording.messages("no.such")) == []
        assert recording.count("no.such") == 0


def test_a_log_without_a_description_finds_its_types_by_fingerprint(tmp_path: Path) -> None:
    with LogWriter(tmp_path / "log") as log:
        log.write("WHEELS", 5, encode(TWISTS[1], 5, 6))
        log.write("OTHER", 5, bytes(40))
    with Recording(tmp_path / "log") as recording:
        assert recording.channels == {"WHEELS": Twist.lcm_class, "OTHER": None}
        assert recording.about is None
        with pytest.raises(LogError, match="does not hold the graph that produced it"):
            _ = recording.graph
        with pytest.raises(LogError, match="the type of channel 'OTHER' is not installed"):
            recording.message("OTHER", 0)


@pytest.mark.parametrize("text", ["", "stages: [", "just words", "\0"])
def test_a_description_that_holds_no_graph_is_said(tmp_path: Path, text: str) -> None:
    with LogWriter(tmp_path / "log") as log:
        log.write(About.CHANNEL, 0, encode(replace(SAID, graph_yaml=text), 0, 0))
    with Recording(tmp_path / "log") as recording, pytest.raises(LogError, match="holds no graph"):
        _ = recording.graph


def test_a_damaged_message_is_an_error_that_names_it(tmp_path: Path) -> None:
    with LogWriter(tmp_path / "log") as log:
        log.write("wheels", 5, encode(TWISTS[1], 5, 6)[:-1])
    with Recording(tmp_path / "log") as recording, pytest.raises(LogError, match="event 0 of channel 'wheels'"):
        recording.message("wheels", 0)


@settings(derandomize=True, deadline=None, max_examples=60)
@given(cut=st.integers(1, 400))
def test_a_truncated_log_is_read_up_to_its_end(tmp_path_factory: pytest.TempPathFactory, cut: int) -> None:
    folder = tmp_path_factory.mktemp("truncated")
    data = write_log(folder / "complete").read_bytes()
    kept = data[: max(1, len(data) - cut)]
    (folder / "truncated").write_bytes(kept)
    with Recording(folder / "complete") as complete, Recording(folder / "truncated") as truncated:
        there = list(truncated.events())
        assert there == list(complete.events())[: len(there)]
        lost = truncated.truncated.n_bytes if truncated.truncated else 0
        assert sum(28 + len(e.channel) + len(e.data) for e in there) + lost == len(kept)
        assert truncated.truncated is None or "is truncated" in str(truncated.truncated)


def test_garbage_in_a_log_is_told_with_its_place(tmp_path: Path) -> None:
    data = write_log(tmp_path / "log").read_bytes()
    place = data.rindex(bytes.fromhex("eda1da01"))
    (tmp_path / "bad").write_bytes(data[:place] + b"????" + data[place + 4 :])
    with Recording(tmp_path / "bad") as recording:
        assert recording.damaged == [(place, len(data) - place)]
        assert recording.n_events == 5


@pytest.mark.parametrize("text", ["stages: {}\n" * 9, "x", "\0" * 64])
def test_a_foreign_file_is_no_log(tmp_path: Path, text: str) -> None:
    (tmp_path / "graph.yaml").write_text(text)
    with pytest.raises(LogError, match=r"graph\.yaml is not an LCM log"):
        Recording(tmp_path / "graph.yaml")


def test_an_empty_log_holds_nothing(tmp_path: Path) -> None:
    (tmp_path / "log").touch()
    with Recording(tmp_path / "log") as recording:
        assert recording.n_events == 0
        assert not recording.channels


@pytest.mark.parametrize("name", ["missing", "."])
def test_a_log_that_cannot_be_opened_is_one_line(tmp_path: Path, name: str) -> None:
    with pytest.raises(LogError, match=r"No such file|Is a directory"):
        Recording(tmp_path / name)


def fill(log: LogWriter, data: bytes) -> None:
    """Write until the disk refuses."""
    for k in itertools.count():
        log.write("x", k, data)


@pytest.mark.parametrize("size", [40, 300_000])
@pytest.mark.parametrize("n_bytes", [1_000_000, 1_000_001, 1_000_050, 1_234_567])
def test_a_full_disk_is_said_and_what_was_recorded_stays_readable(
    disk_of: DiskOf, tmp_path: Path, size: int, n_bytes: int
) -> None:
    path = tmp_path / "log"
    with disk_of(n_bytes):
        log = LogWriter(path)
        with pytest.raises(LogError, match=f"File too large; the log holds {n_bytes // (29 + size)} complete events"):
            fill(log, bytes(size))
        with pytest.raises(LogError):
            log.flush()
        log.close()
    with Recording(path) as recording:
        assert recording.truncated is None
        assert recording.n_events == n_bytes // (29 + size) == log.n_events
        assert recording.utimes("x") == list(range(recording.n_events))


def test_a_disk_that_takes_nothing_is_said() -> None:
    log = LogWriter("/dev/full")
    log.write("x", 0, b"")
    with pytest.raises(LogError, match="No space left on device; the log holds 0 complete events"):
        log.close()


KILLED = """
import os, signal, sys
from graphnav.core.record import LogWriter
log = LogWriter(sys.argv[1])
for k in range(100):
    log.write("x", k, bytes(50_000))
os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_killed_process_loses_only_the_last_events(tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, "-c", KILLED, str(tmp_path / "log")], check=False)
    assert done.returncode == -signal.SIGKILL
    with Recording(tmp_path / "log") as recording:
        assert 100 - 1_048_576 // 50_000 - 1 <= recording.n_events <= 100
        assert recording.truncated is None


def test_what_was_flushed_is_there_before_the_log_is_closed(tmp_path: Path) -> None:
    log = LogWriter(tmp_path / "log")
    log.write("x", 1, b"abc")
    log.flush()
    with Recording(tmp_path / "log") as recording:
        assert recording.n_events == 1
    log.close()
    log.close()


def test_a_log_that_cannot_be_made_is_an_os_error(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="No such file or directory"):
        LogWriter(tmp_path / "no" / "log")


def test_many_small_events_fit_the_kernels_limit(tmp_path: Path) -> None:
    with LogWriter(tmp_path / "log") as log:
        for k in range(5000):
            log.write("x", k, b"")
    with Recording(tmp_path / "log") as recording:
        assert recording.utimes("x") == list(range(5000))


def test_arrays_of_a_closed_recording_stay_valid(tmp_path: Path) -> None:
    flow = Flow(uv_px=np.ones((2, 2, 2), np.float32), valid=np.ones((2, 2), np.uint8), interval_us=1)
    with LogWriter(tmp_path / "log") as log:
        log.write("flow", 1, encode(flow, 1, 0))
    with Recording(tmp_path / "log") as recording:
        message = recording.message("flow", 0)[2]
    os.unlink(tmp_path / "log")
    assert isinstance(message, Flow)
    assert message.valid.sum() == 4


def test_stamps_are_those_of_the_messages_where_a_logger_wrote_the_time_of_day(tmp_path: Path) -> None:
    with LogWriter(tmp_path / "log") as log:
        for k, twist in enumerate(TWISTS):
            log.write("control.twist", 1_700_000_000_000_000 + 7 * k, encode(twist, 100_000 * k, k))
            log.write("stranger", 1_700_000_000_000_000 + 7 * k, b"hello")
    with Recording(tmp_path / "log") as recording:
        assert recording.utimes("control.twist") == [utime for utime, _, _ in recording.messages("control.twist")]
        assert recording.utimes("stranger")[:2] == [1_700_000_000_000_000, 1_700_000_000_000_007]


def test_a_log_begins_with_its_first_event(tmp_path: Path) -> None:
    for name, stamps in (
        ("lockstep", [0, 100_000]),
        ("live", [1_700_000_000_000_000, 1_700_000_000_100_000]),
        ("no", []),
    ):
        with LogWriter(tmp_path / name) as writer:
            for stamp in stamps:
                writer.write("x", stamp, b"12345678")
        with Recording(tmp_path / name) as recording:
            assert recording.begin_us == (stamps[0] if stamps else 0)
