"""What the tests of the page share: a log of a drive, a group of their own, a server in a thread."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from graphnav.bus import require_route
from graphnav.errors import BusError
from graphnav.record import LogWriter
from graphnav.spy import Feed
from graphnav.view import LiveSource, LogSource

from .drive import messages
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
def group() -> str:
    """Return a multicast group that nobody else on this machine uses."""
    url = f"udpm://239.255.79.{os.getpid() % 250 + 1}:{7900 + os.getpid() % 90}?ttl=0"
    try:
        require_route(url)
    except BusError as error:
        pytest.skip(str(error))
    return url


@pytest.fixture
def serve() -> Iterator[Callable[[Path | str], Served]]:
    """Return what serves a log or a group until the test is over."""
    served: list[Served] = []

    def begin(name: Path | str) -> Served:
        feed = Feed(str(name))
        served.append(Served(LiveSource(feed) if feed.is_live else LogSource(feed.path)))
        return served[-1]

    yield begin
    for one in served:
        one.close()
