"""Select the messages of a run that its log keeps."""

from __future__ import annotations

from collections.abc import Collection

from graphnav.runner.owned_stages import Sink

SMALL_BYTES = 4096


class SmallOnly:
    """Passes on messages below 4 kB, and the first of every channel of any size: the map is published once."""

    def __init__(self, sink: Sink) -> None:
        self._sink = sink
        self._begun: set[str] = set()

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Write one message."""
        if len(data) < SMALL_BYTES or channel not in self._begun:
            self._begun.add(channel)
            self._sink.write(channel, utime, data)


class ChannelsOnly:
    """Passes on the messages of given channels."""

    def __init__(self, sink: Sink, channels: Collection[str]) -> None:
        self._sink = sink
        self._channels = frozenset(channels)

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Write one message."""
        if channel in self._channels:
            self._sink.write(channel, utime, data)


class ChannelsExcept:
    """Passes on the messages of all channels except given ones."""

    def __init__(self, sink: Sink, channels: Collection[str]) -> None:
        self._sink = sink
        self._channels = frozenset(channels)

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Write one message."""
        if channel not in self._channels:
            self._sink.write(channel, utime, data)
