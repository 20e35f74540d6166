"""Keep a log small: leave out the messages that pictures and grids are."""

from __future__ import annotations

from graphnav.runner.lockstep import Sink

SMALL_BYTES = 4096


class SmallOnly:
    """Passes on the messages below 4 kB."""

    def __init__(self, sink: Sink) -> None:
        self._sink = sink

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Take one message."""
        if len(data) < SMALL_BYTES:
            self._sink.write(channel, utime, data)
