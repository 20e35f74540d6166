"""Watch a log at an adjustable time."""

from __future__ import annotations

import threading
from array import array
from bisect import bisect_left, bisect_right
from dataclasses import replace
from pathlib import Path

from graphnav.watch.spy.feed import Feed, Received
from graphnav.watch.spy.traffic import ChannelTraffic, Traffic
from graphnav.watch.spy.watch.row import Row, row_of
from graphnav.watch.spy.watch.silence_reasons import why_empty
from graphnav.watch.spy.watch.watch import KEPT_MESSAGES, Sample

_MAX_RECENT_BYTES = 4_000_000


class LogWatch:
    """The channels of a log, and the newest message of each at the time ``at_s``, initially the log's end.

    The table covers the complete log, and is filled while a thread reads it.

    Raises LogError if the log cannot be read.
    """

    is_live = False

    def __init__(self, feed: Feed) -> None:
        self.name = feed.name
        self.path: Path = feed.path
        self._recording = feed.open_log()
        self._traffic = Traffic(None)
        self._lock = threading.Lock()
        self._closing = threading.Event()
        self._times: dict[str, array[float]] = {}
        self._all_times: array[float] = array("d")
        self._at_s: float | None = None
        self._thread = threading.Thread(target=self._read, name="graphnav spy log", daemon=True)

    def start(self) -> None:
        """Start reading."""
        self._thread.start()

    def close(self) -> None:
        """Stop reading and close the file."""
        self._closing.set()
        if self._thread.is_alive():
            self._thread.join()
        self._recording.close()

    @property
    def version(self) -> object:
        """The current time, and the number of events read."""
        return self._at_s, len(self._all_times)

    @property
    def origin_s(self) -> float:
        """The beginning of the log."""
        return self.begin_s

    @property
    def begin_s(self) -> float:
        """The stamp of the first event, seconds."""
        return self._recording.begin_us / 1e6

    @property
    def end_s(self) -> float:
        """The stamp of the newest event that was read, seconds."""
        return self._all_times[-1] if self._all_times else self.begin_s

    @property
    def at_s(self) -> float:
        """The current time."""
        return self.end_s if self._at_s is None else self._at_s

    def go_to(self, at_s: float) -> None:
        """Move to another time, within the log."""
        self._at_s = min(max(at_s, self.begin_s), self.end_s)

    def step(self, name: str | None, count: int) -> None:
        """Step by ``count`` messages of a channel, or by timestamps of all channels if ``name`` is None."""
        with self._lock:
            times = self._all_times if name is None else self._times.get(name)
            if not times:
                return
            at_s = self.at_s
            if count > 0:
                place = bisect_right(times, at_s) + count - 1
            else:
                place = bisect_left(times, at_s) + count
                while name is None and place > 0 and times[place] == times[place - 1]:
                    place -= 1
            self._at_s = times[min(max(place, 0), len(times) - 1)]

    def rows(self) -> list[Row]:
        """Return the channels, in log order."""
        with self._lock:
            now_s, at_s = self.end_s, self.at_s
            return [self._row(channel, now_s, at_s) for channel in self._traffic.channels.values()]

    def channel(self, name: str) -> ChannelTraffic | None:
        """Return the statistics of a channel."""
        return self._traffic.channels.get(name)

    def newest(self, name: str) -> Sample | None:
        """Return the newest message of a channel at the current time."""
        place = self._place(name)
        return None if place is None else self._sample(name, place)

    def recent(self, name: str, after_s: float) -> list[Sample]:
        """Return the last messages of a channel between ``after_s`` and the current time: at most 600, or 4 MB."""
        place = self._place(name)
        if place is None:
            return []
        max_messages = min(KEPT_MESSAGES, _MAX_RECENT_BYTES // (len(self._sample(name, place).data) + 1) + 1)
        first = max(place + 1 - max_messages, bisect_right(self._times[name], after_s, 0, place + 1))
        return [self._sample(name, index) for index in range(first, place + 1)]

    def names_of(self, lcm_class: type) -> list[str]:
        """Return the channels that carry a type."""
        with self._lock:
            return [name for name, channel in self._traffic.channels.items() if channel.lcm_class is lcm_class]

    def why_empty(self, name: str | None) -> str:
        """Return why a channel has no message at the current time, or in the log."""
        channel = self.channel(name) if name is not None else None
        if channel is None:
            return "" if self._traffic.channels or self._thread.is_alive() else f"{self.name} is empty"
        if not channel.count:
            return "announced, but not recorded: the log holds none of its messages"
        place = self._place(channel.name)
        if place is None:
            return f"its first message is at {self._times[channel.name][0] - self.begin_s:.2f} s"
        return why_empty(channel, 0.0)

    def heading(self) -> str:
        """Return a line about the log, the current time, and missing data."""
        parts = [self.name, f"{len(self._traffic.channels)} channels"]
        parts.append(f"at {self.at_s - self.begin_s:.2f} of {self.end_s - self.begin_s:.2f} s")
        if self._thread.is_alive():
            parts.append("reading")
        if self._traffic.overflow:
            parts.append(f"{self._traffic.overflow} messages of further channels not kept")
        if self._recording.truncated is not None:
            parts.append(str(self._recording.truncated))
        return "  ".join(parts)

    def _read(self) -> None:
        for event in self._recording.events():
            if self._closing.is_set():
                return
            at_s = event.utime / 1e6
            with self._lock:
                self._traffic.receive(Received(event.channel, event.data, at_s))
                if event.channel in self._traffic.channels:
                    self._times.setdefault(event.channel, array("d")).append(at_s)
                    self._all_times.append(at_s)

    def _row(self, channel: ChannelTraffic, now_s: float, at_s: float) -> Row:
        row = row_of(channel, now_s, 0.0, None)
        times = self._times.get(channel.name)
        place = bisect_right(times, at_s) if times else 0
        return replace(row, age_s=at_s - times[place - 1] if times and place else None)

    def _place(self, name: str) -> int | None:
        """Return the index of the newest message of a channel at the current time, None before the first."""
        with self._lock:
            times = self._times.get(name)
            place = bisect_right(times, self.at_s) if times else 0
        return place - 1 if place else None

    def _sample(self, name: str, index: int) -> Sample:
        return Sample(self._times[name][index], self._recording.event(name, index).data)
