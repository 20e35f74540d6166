"""Receive a multicast group in a separate thread."""

from __future__ import annotations

from graphnav import GraphnavError
from graphnav.core.errors import one_line
from graphnav.watch.spy import Feed, FeedListener, Received
from graphnav.watch.view.foxglove.arrivals import Arrival, Arrivals


class LiveFeed:
    """Receives a group; it may start before any publisher, and outlives publishers.

    ``failure``: the error that ended it, empty while it runs.
    """

    def __init__(self, feed: Feed) -> None:
        self.name = feed.name
        self.failure = ""
        self.arrivals = Arrivals()
        self._feed, self._epoch_s = feed, feed.epoch_s
        self._n_dropped = 0
        self._listener = FeedListener(feed, self._take, self._fail, "graphnav-foxglove")

    def start(self) -> None:
        """Start receiving."""
        self._listener.start()

    def close(self) -> None:
        """Stop receiving."""
        self._listener.close()

    def newly_dropped_packets(self) -> int:
        """Return the number of packets dropped by the kernel since the last call."""
        before, self._n_dropped = self._n_dropped, self._feed.dropped_packets()
        return self._n_dropped - before

    def _take(self, received: Received) -> None:
        utime = round((received.at_s + self._epoch_s) * 1e6)
        self.arrivals.put(Arrival(received.channel, utime, received.data))

    def _fail(self, error: GraphnavError | OSError) -> None:
        self.failure = one_line(error)
        self.arrivals.wake()
