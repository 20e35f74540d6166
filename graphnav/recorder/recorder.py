"""From a multicast group into a log."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from graphnav.errors import LogError
from graphnav.record import ABOUT, ThreadedLogWriter
from graphnav.record.about_first import AboutFirst
from graphnav.record.channel_filter import ChannelFilter
from graphnav.record.log_files import LogFiles
from graphnav.recorder.listener import Listener
from graphnav.recorder.tally import Tally


class Recorder:
    """Records what is heard on ``url``, from `start` to `close`.

    Events are in the order of their arrival and stamped with the time of day. ``filter`` chooses the channels; what
    describes a run is recorded anyway. ``open_files`` opens the log. ``notice`` is told, from another thread, if the
    disk refuses; ``failure`` then says why.

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
    ) -> None:
        self.tally = Tally()
        self._takes = channels.takes
        self._listener = Listener(url, self._take)
        try:
            self.files = open_files(path)
        except (LogError, OSError):
            self._listener.close()
            raise
        self._log = ThreadedLogWriter(path, notice=notice, open_log=lambda _: AboutFirst(self.files))
        self.unnamed = 0
        """Messages on a channel without a name, which no log can hold."""
        self._is_closed = False
        self.dropped_packets = 0
        """Packets that the kernel dropped before they could be heard."""

    @property
    def failure(self) -> str:
        """Why the recording ended before its time, empty if it did not."""
        return self._log.failure

    @property
    def dropped(self) -> int:
        """Messages that were heard and are not in the log, because the disk did not take them in time."""
        return self._log.dropped

    @property
    def n_bytes(self) -> int:
        """The size of the log."""
        return self._log.n_bytes

    def start(self) -> None:
        """Begin."""
        self._listener.start()

    def look(self) -> None:
        """Ask the kernel what it has dropped."""
        self.dropped_packets = self._listener.dropped_packets()

    def close(self) -> None:
        """Stop listening and complete the log; idempotent."""
        if self._is_closed:
            return
        self._is_closed = True
        self.look()
        self._listener.close()
        self._log.close()

    def _take(self, channel: str, data: bytes) -> None:
        if not channel:
            self.unnamed += 1
        elif channel == ABOUT or self._takes(channel):
            self.tally.hear(channel, data)
            self._log.write(channel, time.time_ns() // 1000, data)
