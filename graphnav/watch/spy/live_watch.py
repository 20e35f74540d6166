"""Watch a multicast group in a separate thread."""

from __future__ import annotations

import time
from pathlib import Path

from graphnav import About
from graphnav.core.errors import shown_name
from graphnav.core.record import ThreadedLogWriter
from graphnav.watch.feed import Feed, LiveFeed, Received, Watch, WatchedChannel
from graphnav.watch.spy.row import Row, row_of
from graphnav.watch.spy.silence_reasons import nothing_received, why_empty

_MAX_NAMED = 3


class LiveWatch:
    """All messages of a live feed.

    The receive thread only counts and stores messages; the viewer may be slow.
    """

    is_live = True

    def __init__(self, feed: Feed) -> None:
        self.name = feed.name
        self._check = feed.check
        self._watch = Watch(feed.clock)
        self._feed = LiveFeed(feed, self._take, name="graphnav-spy")
        self._begin_s = time.monotonic()
        self._clock_offset_s = time.time() - self._begin_s
        self._writer: ThreadedLogWriter | None = None

    @property
    def failure(self) -> str:
        """Why nothing is received, empty while it is."""
        return self._feed.failure

    @property
    def version(self) -> object:
        """The number of received messages."""
        return self._watch.count

    @property
    def origin_s(self) -> float:
        """The current time on the arrival clock."""
        return time.monotonic()

    def start(self) -> None:
        """Start receiving; raises BusError if there is no multicast route."""
        self._check()
        self._feed.start()

    def close(self) -> None:
        """Stop receiving and recording."""
        self._feed.close()
        self.stop_recording()

    def rows(self) -> list[Row]:
        """Return the channels, in order of their first message or announcement."""
        now_s = time.monotonic()
        with self._feed.lock:
            channels = self._watch.channels.values()
            return [row_of(channel, now_s, self._clock_offset_s, channel.silent_s) for channel in channels]

    def channel(self, name: str) -> WatchedChannel | None:
        """Return the statistics of a channel."""
        return self._watch.channels.get(name)

    def newest(self, name: str) -> Received | None:
        """Return the newest message of a channel."""
        with self._feed.lock:
            return self._watch.newest(name)

    def recent(self, name: str, after_s: float) -> list[Received]:
        """Return the stored messages of a channel that arrived after ``after_s``, oldest first."""
        with self._feed.lock:
            return self._watch.recent(name, after_s)

    def names_of(self, lcm_class: type) -> list[str]:
        """Return the channels that carry a type."""
        with self._feed.lock:
            return self._watch.names_of(lcm_class)

    def why_empty(self, name: str | None) -> str:
        """Return why there are no new messages of a channel, or of any."""
        for_s = time.monotonic() - self._begin_s
        channel = self.channel(name) if name is not None else None
        with self._feed.lock:
            if self.failure:
                return self.failure
            if channel is not None:
                return why_empty(channel, for_s)
            return "" if self._watch.channels else nothing_received(self.name, for_s)

    def heading(self) -> str:
        """Return a line about the feed, its channels and runs, dropped packets, counts, and the recording.

        Short, to fit 80 columns.
        """
        with self._feed.lock:
            watch = self._watch
            parts = [self.name.partition("?")[0], f"{len(watch.channels)} channels"]
            if runs := watch.announcements.current_ids(time.monotonic()):
                parts.append(_named(runs))
            if dropped := self._feed.dropped_packets():
                parts.append(f"{dropped} dropped")
            if losses := self._feed.losses:
                parts.append(losses)
            parts.append(f"{watch.count} messages")
            if watch.undecodable:
                parts.append(f"{watch.undecodable} undecodable")
            if watch.overflow:
                parts.append(f"{watch.overflow} messages of further channels not kept")
        if self._writer is not None:
            parts.append(self._writer.failure or f"recording {self._writer.path.name}: {_recorded(self._writer)}")
        if self.failure:
            parts.append(self.failure)
        return "  ".join(parts)

    @property
    def recording(self) -> Path | None:
        """The log being recorded, None without one."""
        return self._writer.path if self._writer is not None else None

    def record(self, path: Path) -> None:
        """Record all messages from now on to a log, preceded by the description of the run.

        Raises OSError if the file cannot be opened.
        """
        writer = ThreadedLogWriter(path)
        with self._feed.lock:
            about = self._watch.newest(About.CHANNEL)
            if about is not None:
                self._write(writer, Received(About.CHANNEL, about.data, time.monotonic()))
            self._writer = writer

    def stop_recording(self) -> str:
        """Close the log being recorded; return a description of its content, empty without one."""
        with self._feed.lock:
            writer, self._writer = self._writer, None
        if writer is None:
            return ""
        writer.close()
        return writer.failure or f"{writer.path}: {_recorded(writer)}"

    def _take(self, received: Received) -> None:
        self._watch.receive(received)
        if self._writer is not None:
            self._write(self._writer, received)

    def _write(self, writer: ThreadedLogWriter, received: Received) -> None:
        """Record a message with the wall time of its arrival, as lcm-logger does."""
        writer.write(received.channel, round((received.at_s + self._clock_offset_s) * 1e6), received.data)


def _named(runs: list[str]) -> str:
    """Return a phrase about the runs, a few by name."""
    names = ", ".join(map(shown_name, runs[:_MAX_NAMED]))
    more = f" and {len(runs) - _MAX_NAMED} more" if len(runs) > _MAX_NAMED else ""
    return f"run {names}" if len(runs) == 1 else f"{len(runs)} runs: {names}{more}"


def _recorded(writer: ThreadedLogWriter) -> str:
    dropped = f", {writer.dropped} dropped" if writer.dropped else ""
    return f"{writer.n_events} messages, {writer.n_bytes / 1e6:.1f} MB{dropped}"
