"""Watch a multicast group in a separate thread."""

from __future__ import annotations

import time
from pathlib import Path

from graphnav import GraphnavError
from graphnav.core.bus import require_route, with_defaults
from graphnav.core.errors import shown_name
from graphnav.core.record import ABOUT, ThreadedLogWriter
from graphnav.watch.spy.feed import Feed, Received
from graphnav.watch.spy.feed_listener import FeedListener
from graphnav.watch.spy.traffic import ChannelTraffic, Traffic
from graphnav.watch.spy.watch.row import Row, row_of
from graphnav.watch.spy.watch.silence_reasons import nothing_received, why_empty
from graphnav.watch.spy.watch.watch import Memory, Sample

_MAX_NAMED = 3


class LiveWatch:
    """Receives all messages of a live feed.

    The receive thread only counts and stores messages; the viewer may be slow. ``failure``: why it ended early, empty
    if it did not.
    """

    is_live = True

    def __init__(self, feed: Feed) -> None:
        self.name = feed.name
        self.failure = ""
        self._feed = feed
        self._memory = Memory(Traffic(feed.clock))
        self._begin_s = time.monotonic()
        self._clock_offset_s = time.time() - self._begin_s
        self._writer: ThreadedLogWriter | None = None
        self._listener = FeedListener(feed, self._take, self._fail, "graphnav-spy")

    @property
    def version(self) -> object:
        """The number of received messages."""
        return self._memory.traffic.count

    @property
    def origin_s(self) -> float:
        """The current time on the arrival clock."""
        return time.monotonic()

    def start(self) -> None:
        """Start receiving; raises BusError if there is no multicast route."""
        require_route(with_defaults(self.name))
        self._listener.start()

    def close(self) -> None:
        """Stop receiving and recording."""
        self._listener.close()
        self.stop_recording()

    def rows(self) -> list[Row]:
        """Return the channels, in order of their first message or announcement."""
        now_s = time.monotonic()
        with self._memory.lock:
            channels = self._memory.traffic.channels.values()
            return [row_of(channel, now_s, self._clock_offset_s, channel.silent_s) for channel in channels]

    def channel(self, name: str) -> ChannelTraffic | None:
        """Return the statistics of a channel."""
        return self._memory.traffic.channels.get(name)

    def newest(self, name: str) -> Sample | None:
        """Return the newest message of a channel."""
        return self._memory.newest(name)

    def recent(self, name: str, after_s: float) -> list[Sample]:
        """Return the stored messages of a channel that arrived after ``after_s``, oldest first."""
        return self._memory.recent(name, after_s)

    def names_of(self, lcm_class: type) -> list[str]:
        """Return the channels that carry a type."""
        return self._memory.names_of(lcm_class)

    def why_empty(self, name: str | None) -> str:
        """Return why there are no new messages of a channel, or of any."""
        for_s = time.monotonic() - self._begin_s
        channel = self.channel(name) if name is not None else None
        with self._memory.lock:
            if self.failure:
                return self.failure
            if channel is not None:
                return why_empty(channel, for_s)
            return "" if self._memory.traffic.channels else nothing_received(self.name, for_s)

    def heading(self) -> str:
        """Return a line about the feed, its channels and runs, dropped packets, counts, and the recording.

        Short, to fit 80 columns.
        """
        with self._memory.lock:
            traffic = self._memory.traffic
            parts = [self.name.partition("?")[0], f"{len(traffic.channels)} channels"]
            if runs := traffic.announcements.current_ids(time.monotonic()):
                parts.append(_named(runs))
            if dropped := self._feed.dropped_packets():
                parts.append(f"{dropped} dropped")
            parts.append(f"{traffic.count} messages")
            if traffic.undecodable:
                parts.append(f"{traffic.undecodable} undecodable")
            if traffic.overflow:
                parts.append(f"{traffic.overflow} messages of further channels not kept")
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
        about = self._memory.newest(ABOUT)
        with self._memory.lock:
            if about is not None:
                self._write(writer, Received(ABOUT, about.data, time.monotonic()))
            self._writer = writer

    def stop_recording(self) -> str:
        """Close the log being recorded; return a description of its content, empty without one."""
        with self._memory.lock:
            writer, self._writer = self._writer, None
        if writer is None:
            return ""
        writer.close()
        return writer.failure or f"{writer.path}: {_recorded(writer)}"

    def _fail(self, error: GraphnavError | OSError) -> None:
        self.failure = str(error)

    def _take(self, received: Received) -> None:
        self._memory.receive(received)
        if self._writer is not None:
            with self._memory.lock:
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
