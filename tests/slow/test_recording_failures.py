"""Recordings that end badly: ``graphnav record`` killed at once, and on a disk that is full."""

from __future__ import annotations

import os
import random
import resource
import signal
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from testbed.drives import GRAPHNAV
from testbed.processes import await_file, group_url

from graphnav import Image, Twist
from graphnav.core.bus import Bus
from graphnav.core.codec import encode
from graphnav.core.record import Recording
from tests.targets import Targets

_N_KILLS = 10
_MAX_KILL_S = 3.0
_MAX_UNWRITTEN_S = 1.0
_FULL_BYTES = 1_000_000
_MAX_TOLD_S = 2.0
_PERIOD_S = 0.002


class Left(NamedTuple):
    """The result of a recording: events, whether their numbers have no gap, damage except the end, bytes at the end."""

    n_events: int
    n_damaged: int
    n_truncated_bytes: int
    last_us: int


def test_damage_by_killing_record(targets: Targets, tmp_path: Path) -> None:
    """Kill a recording at random moments: what is left of it is complete to its last event."""
    drawn = random.Random(8)
    n_good, n_events, n_truncated, unwritten_s = 0, 0, 0, 0.0
    for number in range(_N_KILLS):
        log, url = tmp_path / f"killed-{number}.lcmlog", group_url(201 + number)
        with _recording(log, url) as process, _flood(url):
            await_file(log)
            time.sleep(drawn.uniform(0.0, _MAX_KILL_S))
            process.kill()
            killed_us = time.time_ns() // 1000
            process.wait()
        left = _left(log)
        behind_s = (killed_us - left.last_us) / 1e6 if left.n_events else 0.0
        n_good += left.n_damaged == 0 and behind_s <= _MAX_UNWRITTEN_S
        n_events, n_truncated = n_events + left.n_events, n_truncated + bool(left.n_truncated_bytes)
        unwritten_s = max(unwritten_s, behind_s)
    targets.check(
        f"record killed with -9 at {_N_KILLS} random moments: {n_good} logs readable to the last complete event, "
        f"{n_events} events in all, {n_truncated} ended within one; the last event was {unwritten_s:.2f} s old at most",
        good=n_good == _N_KILLS and n_events > 0,
    )


def test_damage_by_a_file_of_limited_size(targets: Targets, tmp_path: Path) -> None:
    """That no more fits is told at once, and what was written is readable."""
    _fill(targets, "a file of limited size", tmp_path / "limited.lcmlog", group_url(211), _FULL_BYTES)


def test_damage_by_a_full_disk(targets: Targets, tmp_path: Path) -> None:
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", f"size={_FULL_BYTES}", "tmpfs", str(disk)]
    if os.geteuid() != 0 or subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("a small disk cannot be mounted here")
    try:
        _fill(targets, "a full disk", disk / "full.lcmlog", group_url(212))
    finally:
        subprocess.run(["umount", str(disk)], check=True)


def _fill(targets: Targets, what: str, log: Path, url: str, max_bytes: int | None = None) -> None:
    with _recording(log, url, max_bytes) as process, _flood(url):
        await_file(log)
        full_s = _await_size(log, process)
        assert process.stdout is not None
        told = [line.decode().rstrip() for _, line in zip(range(3), process.stdout, strict=False)][2:]
        took_s = time.monotonic() - full_s
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=30)
    left = _left(log)
    good = process.returncode == 1 and any(log.name in line for line in told) and took_s <= _MAX_TOLD_S
    good = good and left.n_damaged == left.n_truncated_bytes == 0 and left.n_events > 0
    targets.check(
        f"record onto {what}: ended with status {process.returncode} {took_s:.1f} s after {_FULL_BYTES} bytes, "
        f"{left.n_events} events readable, {left.n_truncated_bytes} bytes behind them; it said: {' / '.join(told)}",
        good=good,
    )


def _await_size(log: Path, process: subprocess.Popen[bytes]) -> float:
    """Return when the log could not grow any more: it ended, or the file is nearly as large as it may be."""
    while process.poll() is None and log.stat().st_size < _FULL_BYTES * 0.95:
        time.sleep(0.01)
    return time.monotonic()


def _left(log: Path) -> Left:
    with Recording(log) as recording:
        stamps = [event.utime for event in recording.events()]
        n_truncated = recording.truncated.n_bytes if recording.truncated else 0
        return Left(len(stamps), len(recording.damaged), n_truncated, stamps[-1] if stamps else 0)


@contextmanager
def _recording(log: Path, url: str, max_bytes: int | None = None) -> Iterator[subprocess.Popen[bytes]]:
    command = [str(GRAPHNAV), "record", url, "-o", str(log)]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}
    )
    if max_bytes is not None:
        resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (max_bytes, max_bytes))
    try:
        yield process
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGKILL)
        process.communicate()


@contextmanager
def _flood(url: str) -> Iterator[None]:
    """Publish pictures and commands until the end."""
    ending = threading.Event()

    def publish() -> None:
        bus = Bus(url)
        image, seq = Image(pixels=np.zeros((40, 60), np.uint8)), 0
        while not ending.wait(_PERIOD_S):
            stamp = time.time_ns() // 1000
            bus.publish("CAMERA", encode(image, stamp, seq))
            bus.publish("COMMAND", encode(Twist(v_mps=0.1, omega_radps=0.0), stamp, seq))
            seq += 1
        bus.close()

    thread = threading.Thread(target=publish)
    thread.start()
    try:
        yield
    finally:
        ending.set()
        thread.join()
