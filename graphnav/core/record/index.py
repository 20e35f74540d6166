"""The positions of a log's events, 30 bytes per event."""

from __future__ import annotations

import sys
from array import array

from graphnav.core.record.event import Entry


class Index:
    """All events in file order, and by channel."""

    def __init__(self) -> None:
        self.channels: dict[str, array[int]] = {}
        """Event numbers by channel."""
        self._channel: list[str] = []
        self._utime, self._start, self._stop = (array("q") for _ in range(3))

    def __len__(self) -> int:
        return len(self._utime)

    def add(self, entry: Entry) -> None:
        """Append an event."""
        channel = sys.intern(entry.channel)
        self.channels.setdefault(channel, array("q")).append(len(self))
        self._channel.append(channel)
        self._utime.append(entry.utime)
        self._start.append(entry.start)
        self._stop.append(entry.stop)

    def __getitem__(self, number: int) -> Entry:
        return Entry(self._channel[number], self._utime[number], self._start[number], self._stop[number])

    def of(self, channel: str, index: int) -> Entry:
        """Return an event of a channel; ``index`` counts within it, from the end if negative."""
        return self[self.channels[channel][index]]
