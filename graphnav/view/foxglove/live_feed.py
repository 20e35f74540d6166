"""A multicast group as it arrives, heard by a thread that does nothing else."""

from __future__ import annotations

import threading
from contextlib import closing

from graphnav.errors import GraphnavError, one_line
from graphnav.spy import Feed
from graphnav.view.foxglove.arrivals import Arrival, Arrivals


class LiveFeed:
    """Listens on a group; it may start before anybody publishes there, and outlives those who do.

    ``failure`` says what ended it, empty while it goes on.
    """

    def __init__(self, feed: Feed) -> None:
        self.name = feed.name
        self.failure = ""
        self.arrivals = Arrivals()
        self._feed, self._epoch_s = feed, feed.epoch_s
        self._n_dropped = 0
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._listen, name="graphnav-foxglove", daemon=True)

    def start(self) -> None:
        """Begin to listen."""
        self._thread.start()

    def close(self) -> None:
        """Stop listening."""
        self._closing.set()
        self._thread.join()

    def newly_dropped_packets(self) -> int:
        """Return how many packets the kernel has dropped since the last time, before they could be heard."""
        before, self._n_dropped = self._n_dropped, self._feed.dropped_packets()
        return self._n_dropped - before

    def _listen(self) -> None:
        try:
            with closing(self._feed.listen(None)) as heard_all:
                for heard in heard_all:
                    if self._closing.is_set():
                        return
                    if heard is not None:
                        utime = round((heard.at_s + self._epoch_s) * 1e6)
                        self.arrivals.put(Arrival(heard.channel, utime, heard.data))
        except (GraphnavError, OSError) as error:
            self.failure = one_line(error)
            self.arrivals.wake()
