"""A multicast group as it arrives, heard by a thread that does nothing else."""

from __future__ import annotations

import threading
import time

from graphnav.bus import Bus
from graphnav.errors import GraphnavError, one_line
from graphnav.spy import Feed
from graphnav.view.foxglove.arrivals import Arrival, Arrivals

_PATIENCE_S = 0.1
_MAX_WAITING = 1024
"""So many messages wait within LCM; what comes when that is full is lost, as in any flood."""


class LiveFeed:
    """Listens on a group; it may start before anybody publishes there, and outlives those who do.

    ``failure`` says what ended it, empty while it goes on.
    """

    def __init__(self, feed: Feed) -> None:
        self.name = feed.name
        self.failure = ""
        self.arrivals = Arrivals()
        self._epoch_s = feed.epoch_s
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._listen, name="graphnav-foxglove", daemon=True)

    def start(self) -> None:
        """Begin to listen."""
        self._thread.start()

    def close(self) -> None:
        """Stop listening."""
        self._closing.set()
        self._thread.join()

    def _listen(self) -> None:
        try:
            bus = Bus(self.name)
            bus.subscribe_all(self._hear, _MAX_WAITING)
            try:
                while not self._closing.is_set():
                    bus.handle(_PATIENCE_S)
            finally:
                bus.close()
        except (GraphnavError, OSError) as error:
            self.failure = one_line(error)
            self.arrivals.wake()

    def _hear(self, channel: str, data: bytes) -> None:
        self.arrivals.put(Arrival(channel, round((time.monotonic() + self._epoch_s) * 1e6), data))
