"""Keep a log small: leave out the messages that pictures and grids are."""

from __future__ import annotations

from graphnav.runner.lockstep import Sink

SMALL_BYTES = 4096


class SmallOnly:
    """Passes on the messages below 4 kB, and the first of every channel, however large: the map comes once."""

    def __init__(self, sink: Sink) -> None:
        self._sink = sink
        self._begun: set[str] = set()

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Take one message."""
        if len(data) < SMALL_BYTES or channel not in self._begun:
            self._begun.add(channel)
            self._sink.write(channel, utime, data)
