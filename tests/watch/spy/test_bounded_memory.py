"""Channels and runs that other programs invent are bounded, and what is not kept is reported once."""

from __future__ import annotations

from pathlib import Path

import pytest
from rich.text import Text

from graphnav.core.cli import main
from graphnav.core.codec import encode
from graphnav.core.messages import About, Status, Twist
from graphnav.core.record import LogWriter
from graphnav.watch.feed import MAX_CHANNELS, Health, Received, Watch
from graphnav.watch.spy import as_text, health_as_text

N_RUNS = 40
LAST = f"c{MAX_CHANNELS + 9}"


def runs() -> list[Received]:
    """Return announcements and statuses of more runs than are kept."""
    abouts = [encode(About("", "", f"run-{k}", 7, (), ()), k, 0) for k in range(N_RUNS)]
    statuses = [
        encode(Status(f"run-{k}", "graph", False, 0, 0, 0, 0, 0, 0, "", (), (), (), ()), k, 0) for k in range(N_RUNS)
    ]
    return [Received(About.CHANNEL, data, 0.0) for data in abouts] + [Received("s", data, 0.0) for data in statuses]


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """Return a log of more channels than are kept, two messages on each."""
    path = tmp_path / "log"
    with LogWriter(path) as writer:
        for k in range(2):
            for number in range(MAX_CHANNELS + 10):
                writer.write(f"c{number}", 100_000 * k, encode(Twist(0.1, 0.2), 100_000 * k, k))
    return path


def test_the_newest_runs_are_kept_and_that_is_said() -> None:
    watch = Watch()
    for received in runs()[:32]:
        watch.receive(received)
    assert "are kept" not in as_text(watch, "").plain
    for received in runs()[:N_RUNS]:
        watch.receive(received)
    assert len(watch.announcements.runs) == 32
    assert as_text(watch, "").plain.count("only the newest 32 runs are kept") == 1


def test_the_health_of_the_newest_runs_is_kept_and_that_is_said() -> None:
    health = Health()
    for received in runs():
        health.receive(received)
    assert len(health.runs) == 32
    shown = health_as_text(health, 100)
    assert Text("only the newest 32 runs and guards are kept") in list(getattr(shown, "renderables", []))


@pytest.mark.parametrize("command", ["hz", "bw"])
def test_more_channels_than_are_kept_are_reported_once(
    command: str, log: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([command, str(log)]) == 0
    told = capsys.readouterr()
    assert told.err == f"only the first {MAX_CHANNELS} channels are measured\n"
    assert LAST not in told.out


@pytest.mark.parametrize("command", ["hz", "bw", "echo"])
def test_the_wanted_channel_is_always_kept(command: str, log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([command, LAST, str(log)]) == 0
    told = capsys.readouterr()
    assert LAST in told.out
    assert not told.err
