"""Record a multicast group to a log, and count what it loses."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

from graphnav import About, Status
from graphnav.core.codec import DecodeError, decode
from graphnav.core.errors import LogError
from graphnav.core.machine import ReceiveBuffer
from graphnav.core.record import AboutFirst, ChannelFilter, LogFiles, ThreadedLogWriter
from graphnav.watch.channel_account import ChannelCounts, Kind, kind_of
from graphnav.watch.feed import Feed, LiveFeed, Received

_MAX_CHANNELS = 10_000
"""Further channels are counted together, to bound memory when a program sends random names."""
_MAX_RUNS = 32
"""Of further runs it is not told how much their taps left out."""


class RecordedChannel(ChannelCounts):
    """The counts of one channel.

    ``fingerprint``: the first 8 bytes of the first message. ``kind``: its type, None if it is not known.
    """

    __slots__ = ("fingerprint", "kind")

    def __init__(self, fingerprint: bytes = b"", kind: Kind | None = None) -> None:
        super().__init__()
        self.fingerprint, self.kind = fingerprint, kind

    @property
    def lost(self) -> int | None:
        """The number of missing sequence numbers, None if messages have none."""
        return self.gaps.lost if self.kind is not None and self.kind.is_stamped else None


class ReceiveStatistics:
    """The counts of all channels; one thread counts, others may read."""

    def __init__(self) -> None:
        self.n_messages = self.n_bytes = 0
        self.channels: dict[str, RecordedChannel] = {}
        self.others = RecordedChannel()
        """Messages on channels beyond the first 10,000."""
        self._tap_dropped: dict[str, tuple[int, int]] = {}

    @property
    def left_out(self) -> int:
        """The number of messages that the taps of runs left out meanwhile, as their statuses tell once a second."""
        return sum(newest - before for before, newest in list(self._tap_dropped.values()))

    @property
    def lost(self) -> int:
        """The number of missing sequence numbers."""
        return sum(channel.lost or 0 for channel in list(self.channels.values()))

    def receive(self, name: str, data: bytes, at_s: float) -> None:
        """Count a message."""
        channel = self.channels.get(name)
        if channel is None:
            channel = self._add(name, data)
        channel.add(len(data), at_s)
        self.n_messages += 1
        self.n_bytes += len(data)
        if name == Status.CHANNEL:
            self._see_status(data)
        kind = channel.kind
        if kind is not None and kind.is_stamped and data.startswith(channel.fingerprint):
            stamp = kind.stamp(data)
            if stamp is not None:
                channel.gaps.see(stamp[1])

    def _see_status(self, data: bytes) -> None:
        """Note what the tap of a run has left out; all of that before its first status if that is heard."""
        try:
            _, seq, status = decode(Status, data)
        except DecodeError:
            return
        if status.run_id in self._tap_dropped or len(self._tap_dropped) < _MAX_RUNS:
            before, _ = self._tap_dropped.get(status.run_id, (status.tap_dropped if seq else 0, 0))
            self._tap_dropped[status.run_id] = before, status.tap_dropped

    def _add(self, name: str, data: bytes) -> RecordedChannel:
        if len(self.channels) >= _MAX_CHANNELS:
            return self.others
        channel = self.channels[name] = RecordedChannel(data[:8], kind_of(data))
        return channel


class Recorder:
    """Records the messages received on a live feed, from `start` to `close`.

    Events are in order of arrival, stamped with wall time. ``filter`` selects the channels; descriptions of runs are
    always recorded. ``open_files`` opens the log, which gets ``definitions`` of types. ``notice`` is called from
    another thread if the disk fails; ``failure`` then holds the reason.

    Raises BusError if LCM cannot be opened, UserError as `Feed` and `Feed.open` do, OSError if the log cannot, LogError
    if the disk has less than its quota from the beginning.
    """

    def __init__(
        self,
        feed: str,
        path: Path,
        channels: ChannelFilter,
        open_files: Callable[[Path], LogFiles] = LogFiles,
        notice: Callable[[str], None] = lambda _: None,
        definitions: str = "",
    ) -> None:
        self.statistics = ReceiveStatistics()
        self.unnamed = 0
        """Messages with an empty channel name, which cannot be logged."""
        self.dropped_packets = 0
        """Packets dropped by the kernel."""
        self._is_closed = False
        self._takes = channels.takes
        opened = Feed(feed)
        self.feed_name = opened.name
        self._feed = LiveFeed(opened, self._take, name="graphnav-listener")
        self._feed.open()
        try:
            self.files = open_files(path)
        except (LogError, OSError):
            self._feed.close()
            raise
        self._log = ThreadedLogWriter(
            path, notice=notice, open_log=lambda _: AboutFirst(self.files, definitions=definitions)
        )

    @property
    def feed_failure(self) -> str:
        """Why nothing is received, empty while it is."""
        return self._feed.failure

    @property
    def feed_losses(self) -> str:
        """A phrase about what another computer has dropped in place of sending it; empty if there is nothing."""
        return self._feed.losses

    @property
    def failure(self) -> str:
        """Why the recording ended early, empty if it did not."""
        return self._log.failure

    @property
    def dropped(self) -> int:
        """Messages that were received but not logged, because the disk was too slow."""
        return self._log.dropped

    @property
    def n_bytes(self) -> int:
        """The size of the log."""
        return self._log.n_bytes

    def start(self) -> None:
        """Begin."""
        self._feed.start()

    def look(self) -> None:
        """Update the number of packets dropped by the kernel."""
        self.dropped_packets = self._feed.dropped_packets()

    def close(self) -> None:
        """Stop receiving and complete the log; idempotent."""
        if self._is_closed:
            return
        self._is_closed = True
        self.look()
        self._feed.close()
        self._log.close()

    def _take(self, received: Received) -> None:
        channel, data, _ = received
        if not channel:
            self.unnamed += 1
        elif channel == About.CHANNEL or self._takes(channel):
            utime = time.time_ns() // 1000
            self.statistics.receive(channel, data, utime / 1e6)
            self._log.write(channel, utime, data)


def buffer_notice(url: str) -> str:
    """Return a warning if the kernel grants less than the URL requests, else an empty string."""
    wanted = parse_qs(urlsplit(url).query).get("recv_buf_size", ["0"])[-1]
    try:
        wanted_bytes = int(wanted)
    except ValueError:
        return ""
    if (granted_bytes := ReceiveBuffer.limit()) >= wanted_bytes:
        return ""
    return (
        f"the kernel grants {granted_bytes} bytes of receive buffer, {wanted_bytes} are requested: large messages will "
        f"be lost\n  run as root: sysctl -w net.core.rmem_max={wanted_bytes}"
    )
