"""Numbers of messages from 0 on, in the log of a replay that does not begin at the beginning."""

from __future__ import annotations

from graphnav.runner.owned_stages import Sink

_SEQ = slice(16, 24)
"""Where a message has its number, behind the fingerprint and the stamp."""


class Renumbered:
    """A sink that takes the first number of each channel off all of its numbers; gaps stay."""

    def __init__(self, sink: Sink) -> None:
        self._sink = sink
        self._first: dict[str, int] = {}

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Pass a message on."""
        seq = int.from_bytes(data[_SEQ], "big", signed=True)
        first = self._first.setdefault(channel, seq)
        number = (seq - first) & (1 << 64) - 1
        self._sink.write(channel, utime, data[: _SEQ.start] + number.to_bytes(8, "big") + data[_SEQ.stop :])
