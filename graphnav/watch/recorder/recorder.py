"""Record a multicast group to a log."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from graphnav import About
from graphnav.core.errors import LogError
from graphnav.core.record import AboutFirst, ChannelFilter, LogFiles, ThreadedLogWriter
from graphnav.watch.feed import Feed, LiveFeed, Received
from graphnav.watch.recorder.channel_statistics import ReceiveStatistics


class Recorder:
    """Records the messages received on ``url``, from `start` to `close`.

    Events are in order of arrival, stamped with wall time. ``filter`` selects the channels; descriptions of runs are
    always recorded. ``open_files`` opens the log, which gets ``definitions`` of types. ``notice`` is called from
    another thread if the disk fails; ``failure`` then holds the reason.

    Raises BusError if LCM cannot be opened, OSError if the log cannot, LogError if the
    disk has less than its quota from the beginning.
    """

    def __init__(
        self,
        url: str,
        path: Path,
        channels: ChannelFilter,
        open_files: Callable[[Path], LogFiles] = LogFiles,
        notice: Callable[[str], None] = lambda _: None,
        definitions: str = "",
    ) -> None:
        self.statistics = ReceiveStatistics()
        self._takes = channels.takes
        self._feed = LiveFeed(Feed(url), self._take, name="graphnav-listener")
        self._feed.open()
        try:
            self.files = open_files(path)
        except (LogError, OSError):
            self._feed.close()
            raise
        self._log = ThreadedLogWriter(
            path, notice=notice, open_log=lambda _: AboutFirst(self.files, definitions=definitions)
        )
        self.unnamed = 0
        """Messages with an empty channel name, which cannot be logged."""
        self._is_closed = False
        self.dropped_packets = 0
        """Packets dropped by the kernel."""

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
