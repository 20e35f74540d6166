"""Fixtures of the page tests: the log of a drive, a private group, a server in a thread."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from graphnav import Status
from graphnav.core.codec import encode
from graphnav.core.record import LogWriter
from graphnav.watch.feed import Feed
from graphnav.watch.view import PageFeed

from .drive import N_FRAMES, PERIOD_US, messages, status_of_processes
from .foxglove_client import FoxgloveServed
from .served import Served


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """Return a log of a drive of 4 s."""
    path = tmp_path / "drive.lcmlog"
    with LogWriter(path) as writer:
        for channel, utime, data in messages():
            writer.write(channel, utime, data)
    return path


@pytest.fixture
def log_of_processes(log: Path) -> Path:
    """Return the log of such a drive over three processes."""
    path = log.with_name("processes.lcmlog")
    with LogWriter(path) as writer:
        for channel, utime, data in messages():
            if channel != Status.CHANNEL:
                writer.write(channel, utime, data)
        utime = (N_FRAMES - 1) * PERIOD_US
        writer.write(Status.CHANNEL, utime, encode(status_of_processes(N_FRAMES - 1), utime, 0))
    return path


@pytest.fixture
def serve() -> Iterator[Callable[[Path | str], Served]]:
    """Return a function that serves a log or a group until the end of the test."""
    served: list[Served] = []

    def begin(name: Path | str) -> Served:
        served.append(Served(PageFeed(Feed(str(name)))))
        return served[-1]

    yield begin
    for one in served:
        one.close()


@pytest.fixture
def serve_foxglove() -> Iterator[Callable[[Path | str], FoxgloveServed]]:
    """Return a function that serves a log or a group to Foxglove until the end of the test."""
    with ExitStack() as served:

        def begin(name: Path | str) -> FoxgloveServed:
            one = FoxgloveServed(str(name))
            served.callback(one.close)
            return one

        yield begin
