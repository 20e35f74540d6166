"""Receive a multicast group in a thread."""

from __future__ import annotations

import threading
import time

from graphnav import GraphnavError
from graphnav.core.errors import one_line
from graphnav.watch.spy import Feed, FeedListener, Received
from graphnav.watch.view.watch import Watch


class LiveSource:
    """Receives a group; it may start before any publisher, and outlives publishers."""

    def __init__(self, feed: Feed) -> None:
        self.lock = threading.Lock()
        self.watch = Watch(time.monotonic)
        self.name = feed.name
        self.failure = ""
        self._feed = feed
        self._listener = FeedListener(feed, self._take, self._fail, "graphnav-view")

    def dropped_packets(self) -> int:
        """Return the number of packets dropped by the kernel."""
        return self._feed.dropped_packets()

    def start(self) -> None:
        """Start receiving."""
        self._listener.start()

    def close(self) -> None:
        """Stop receiving."""
        self._listener.close()

    def _take(self, received: Received) -> None:
        with self.lock:
            self.watch.receive(received)

    def _fail(self, error: GraphnavError | OSError) -> None:
        self.failure = one_line(error)
