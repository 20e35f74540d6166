"""LCM's own tools, as they come in the wheel, understand what we write and send."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import lcm
import numpy as np

from graphnav.core.bus import Bus
from graphnav.core.codec import encode
from graphnav.core.messages import Flow, Image, Message, State, Twist
from graphnav.core.record import LogWriter, Recording

from .conftest import TOOLS

RNG = np.random.default_rng(3)


def some_messages() -> list[tuple[str, Message]]:
    """Return what one tick publishes, in small."""
    shape = (30, 40)
    return [
        ("robot.image", Image(pixels=RNG.integers(0, 255, (*shape, 3), dtype=np.uint8))),
        (
            "flow.flow",
            Flow(
                uv_px=RNG.normal(size=(*shape, 2)).astype(np.float32),
                valid=RNG.integers(0, 2, shape, dtype=np.uint8),
                interval_us=100_000,
            ),
        ),
        (
            "robot.state",
            State(1.5, -2.5, 0.1, 0.3, -0.2, 0.7, contact=False, at_goal=True, moving=RNG.normal(size=(2, 3))),
        ),
        ("control.twist", Twist(v_mps=0.3, omega_radps=-0.1)),
    ]


def write_run(path: Path, ticks: int = 20) -> list[tuple[str, int, bytes]]:
    """Write a log and return its events."""
    written = []
    with LogWriter(path) as log:
        for k in range(ticks):
            for channel, message in some_messages():
                event = (channel, 20_000 * k, encode(message, 20_000 * k, k))
                log.write(*event)
                written.append(event)
    return written


@contextmanager
def running(command: list[Any]) -> Iterator[subprocess.Popen[bytes]]:
    """Run a tool until the block ends."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield process
    finally:
        process.terminate()
        process.wait(10)


def test_lcm_logplayer_plays_our_log(tmp_path: Path, group: str) -> None:
    written = write_run(tmp_path / "run.lcmlog")
    listener = lcm.LCM(f"{group}&recv_buf_size=2097152")
    received: list[tuple[str, bytes]] = []
    subscription = listener.subscribe(".*", lambda channel, data: received.append((channel, data)))
    subscription.set_queue_capacity(0)
    command = [TOOLS / "lcm-logplayer", "--lcm-url", group, tmp_path / "run.lcmlog"]
    with running(command) as player:
        while len(received) < len(written) and listener.handle_timeout(5000):
            pass
        assert player.wait(10) == 0
    assert received == [(channel, data) for channel, _, data in written]


def test_lcm_logger_records_what_we_publish(tmp_path: Path, group: str) -> None:
    path = tmp_path / "theirs.lcmlog"
    bus = Bus(group)
    sent = []
    with running([TOOLS / "lcm-logger", "--lcm-url", group, "--flush-interval", "20", path]):
        _publish_until_logged(bus, "mark-start", path)
        for k in range(8):
            for channel, message in some_messages():
                sent.append((channel, encode(message, 20_000 * k, k)))
                bus.publish(*sent[-1])
            _publish_until_logged(bus, f"mark-{k}", path)
    # liblcm tests itself when it starts, and the logger may receive its own test.
    events = [
        (event.channel, event.data)
        for event in _events(path)
        if not event.channel.startswith("mark") and event.channel != "LCM_SELF_TEST"
    ]
    assert events == sent


def test_lcm_gen_decodes_every_message_of_our_log(tmp_path: Path) -> None:
    write_run(tmp_path / "run.lcmlog", ticks=2)
    with Recording(tmp_path / "run.lcmlog") as recording:
        for channel, lcm_class in recording.channels.items():
            for index in range(recording.count(channel)):
                event = recording.event(channel, index)
                made: Any = getattr(lcm_class, "decode")(event.data)  # noqa: B009 - lcm-gen's classes are not typed
                assert (made.utime, made.seq) == (event.utime, index)
                assert made.encode() == event.data


def test_lcm_logfilter_cuts_our_log(tmp_path: Path) -> None:
    write_run(tmp_path / "run.lcmlog")
    command = [str(TOOLS / "lcm-logfilter"), "-c", r"robot\..*"]
    subprocess.run([*command, tmp_path / "run.lcmlog", tmp_path / "cut.lcmlog"], check=True, capture_output=True)
    with Recording(tmp_path / "cut.lcmlog") as cut:
        assert set(cut.channels) == {"robot.image", "robot.state"}


def _events(path: Path) -> list[Any]:
    """Return the complete events of a log that may still grow; lcm-logger's flush may truncate the last one."""
    if not path.exists():
        return []
    with Recording(path) as recording:
        return list(recording.events())


def _publish_until_logged(bus: Bus, channel: str, path: Path) -> None:
    """Publish an empty message again and again, which makes lcm-logger flush, until it is in the log."""
    deadline_s = time.monotonic() + 20
    while all(event.channel != channel for event in _events(path)):
        assert time.monotonic() < deadline_s
        bus.publish(channel, b"")
        bus.handle(0.02)
