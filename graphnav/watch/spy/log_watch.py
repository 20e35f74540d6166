"""Watch a log at an adjustable time."""

from __future__ import annotations

import threading
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from graphnav.watch.feed import KEPT_MESSAGES, Feed, Received, StoppableThread, Watch, WatchedChannel
from graphnav.watch.log_cursor import LogCursor
from graphnav.watch.spy.row import Row, row_of
from graphnav.watch.spy.silence_reasons import why_empty

_MAX_RECENT_BYTES = 4_000_000


class LogWatch:
    """The channels of a log, and the newest message of each at the time ``at_s``, initially the log's end.

    The table covers the complete log, and is filled while a thread reads it. The time moves while it plays, at each
    call of `advance`.

    Raises LogError if the log cannot be read.
    """

    is_live = False

    def __init__(self, feed: Feed) -> None:
        self.name = feed.name
        self.path: Path = feed.path
        self._recording = feed.open_log()
        self._watch = Watch()
        self._lock = threading.Lock()
        self._n_read = 0
        self._read_s = self.begin_s
        self._cursor = LogCursor(self._recording)
        self._cursor.pause()
        self._seek(self._cursor.end_us)
        self._thread = StoppableThread(self._read, "graphnav spy log")

    def start(self) -> None:
        """Start reading."""
        self._thread.start()

    def close(self) -> None:
        """Stop reading and close the file."""
        self._thread.stop()
        self._recording.close()

    @property
    def version(self) -> object:
        """The current time, and the number of events read."""
        return self.at_s, self._n_read

    @property
    def origin_s(self) -> float:
        """The beginning of the log."""
        return self.begin_s

    @property
    def begin_s(self) -> float:
        """The stamp of the first event, seconds."""
        return self._recording.begin_us / 1e6

    @property
    def at_s(self) -> float:
        """The current time."""
        return self.begin_s + self._cursor.at_us / 1e6

    @property
    def is_playing(self) -> bool:
        """Whether the time moves."""
        return not self._cursor.is_paused

    def toggle(self) -> None:
        """Play in real time, from the beginning if it is at the end; or pause."""
        if self.is_playing:
            self._cursor.pause()
            return
        if self._cursor.is_at_end:
            self._cursor.seek(0)
        self._cursor.resume()

    def advance(self) -> None:
        """Move on, and pause at the end."""
        self._cursor.due()
        if self._cursor.is_at_end:
            self._cursor.pause()

    def skip(self, seconds: float) -> None:
        """Move by seconds, within the log."""
        self._seek(self._cursor.at_us + seconds * 1e6)

    def step(self, name: str | None, count: int) -> None:
        """Pause, and step by ``count`` messages of a channel, or by timestamps of all channels if ``name`` is None."""
        self._cursor.pause()
        if name is None or name in self._recording.index.channels:
            self._cursor.step(count, name)
            self._cursor.due()

    def rows(self) -> list[Row]:
        """Return the channels, in log order."""
        with self._lock:
            now_s, at_s = self._read_s, self.at_s
            return [self._row(channel, now_s, at_s) for channel in self._watch.channels.values()]

    def channel(self, name: str) -> WatchedChannel | None:
        """Return the statistics of a channel."""
        return self._watch.channels.get(name)

    def newest(self, name: str) -> Received | None:
        """Return the newest message of a channel at the current time."""
        numbers = self._cursor.newest(name)
        return self._received(numbers[-1]) if numbers else None

    def recent(self, name: str, after_s: float) -> list[Received]:
        """Return the last messages of a channel between ``after_s`` and the current time: at most 600, or 4 MB."""
        numbers = self._cursor.newest(name, KEPT_MESSAGES)
        if not numbers:
            return []
        newest = self._recording.index[numbers[-1]]
        max_messages = _MAX_RECENT_BYTES // (newest.stop - newest.start + 1) + 1
        first = max(len(numbers) - max_messages, bisect_right(numbers, after_s, key=self._time_s))
        return [self._received(number) for number in numbers[first:]]

    def names_of(self, lcm_class: type) -> list[str]:
        """Return the channels that carry a type."""
        with self._lock:
            return [name for name, channel in self._watch.channels.items() if channel.lcm_class is lcm_class]

    def why_empty(self, name: str | None) -> str:
        """Return why a channel has no message at the current time, or in the log."""
        channel = self.channel(name) if name is not None else None
        if channel is None:
            return "" if self._watch.channels or self._thread.is_alive() else f"{self.name} is empty"
        numbers: Sequence[int] = self._recording.index.channels.get(channel.name, ())
        if not numbers:
            return "announced, but not recorded: the log holds none of its messages"
        if not self._cursor.newest(channel.name):
            return f"its first message is at {self._cursor.time_us(numbers[0]) / 1e6:.2f} s"
        return why_empty(channel, 0.0)

    def heading(self) -> str:
        """Return a line about the log, the current time, and missing data."""
        parts = [self.name, f"{len(self._watch.channels)} channels"]
        parts.append(f"at {self._cursor.at_us / 1e6:.2f} of {self._cursor.end_us / 1e6:.2f} s")
        if self._thread.is_alive():
            parts.append("reading")
        if self._watch.overflow:
            parts.append(f"{self._watch.overflow} messages of further channels not kept")
        if self._recording.truncated is not None:
            parts.append(str(self._recording.truncated))
        return "  ".join(parts)

    def _read(self) -> None:
        for event in self._recording.events():
            if self._thread.stopping.is_set():
                return
            with self._lock:
                self._read_s = event.utime / 1e6
                self._watch.receive(Received(event.channel, event.data, self._read_s))
                self._n_read += 1

    def _seek(self, at_us: float) -> None:
        self._cursor.seek(at_us)
        self._cursor.due()

    def _row(self, channel: WatchedChannel, now_s: float, at_s: float) -> Row:
        numbers = self._cursor.newest(channel.name)
        age_s = max(0.0, at_s - self._time_s(numbers[-1])) if numbers else None
        return replace(row_of(channel, now_s, 0.0, None), age_s=age_s)

    def _time_s(self, number: int) -> float:
        return self.begin_s + self._cursor.time_us(number) / 1e6

    def _received(self, number: int) -> Received:
        event = self._recording.at(number)
        return Received(event.channel, event.data, self._time_s(number))
