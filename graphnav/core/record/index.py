"""The events of a log: their positions, and their times, corrected for jumps of the timestamps."""

from __future__ import annotations

import sys
from array import array
from collections.abc import Sequence

from graphnav.core.record.event import Entry

_MAX_GAP_US = 86_400_000_000
"""A longer gap between two events is a clock that was set, or a damaged timestamp."""


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


class Timeline:
    """The non-decreasing times of events, microseconds since the first one.

    ``utimes``: the timestamps of the events in file order. A timestamp that fits neither the previous nor the next one
    is replaced by the previous one; if a clock was set, time continues without a step. ``n_jumps`` counts both.
    """

    def __init__(self, utimes: Sequence[int]) -> None:
        self.at_us = array("q")
        self.n_jumps = 0
        now, clock = 0, utimes[0] if utimes else 0
        for number, utime in enumerate(utimes):
            following = utimes[number + 1] if number + 1 < len(utimes) else None
            step = utime - clock
            is_step = 0 <= step <= _MAX_GAP_US
            if is_step and (following is None or not clock <= following < utime):
                now, clock = now + step, utime
            else:
                self.n_jumps += 1
                if not is_step and (following is None or not 0 <= following - clock <= _MAX_GAP_US):
                    clock = utime
            self.at_us.append(now)

    def __len__(self) -> int:
        return len(self.at_us)

    @property
    def duration_us(self) -> int:
        """The time of the last event."""
        return self.at_us[-1] if self.at_us else 0
