"""Renumber messages from 0 in the log of a replay that starts later than the recorded run."""

from __future__ import annotations

from graphnav.runner.owned_stages import Sink

_SEQ = slice(16, 24)
"""Position of the sequence number, after the fingerprint and the timestamp."""


class Renumbered:
    """A sink that subtracts the first number of each channel; gaps are preserved."""

    def __init__(self, sink: Sink) -> None:
        self._sink = sink
        self._first: dict[str, int] = {}

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Pass a message on."""
        seq = int.from_bytes(data[_SEQ], "big", signed=True)
        first = self._first.setdefault(channel, seq)
        number = (seq - first) & (1 << 64) - 1
        self._sink.write(channel, utime, data[: _SEQ.start] + number.to_bytes(8, "big") + data[_SEQ.stop :])
