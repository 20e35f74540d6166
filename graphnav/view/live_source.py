"""A multicast group, listened to by a thread."""

from __future__ import annotations

import threading
import time

from graphnav.errors import GraphnavError, one_line
from graphnav.spy import Feed
from graphnav.view.watch import Watch


class LiveSource:
    """Listens on a group; it may start before anybody publishes there, and outlives those who do."""

    def __init__(self, feed: Feed) -> None:
        self.lock = threading.Lock()
        self.watch = Watch(time.monotonic)
        self.name = feed.name
        self.failure = ""
        self._feed = feed
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._listen, name="graphnav-view", daemon=True)

    def dropped_packets(self) -> int:
        """Return how many packets the kernel dropped before they could be heard."""
        return self._feed.dropped_packets()

    def start(self) -> None:
        """Begin to listen."""
        self._thread.start()

    def close(self) -> None:
        """Stop listening."""
        self._closing.set()
        self._thread.join()

    def _listen(self) -> None:
        try:
            for heard in self._feed.listen(None):
                if self._closing.is_set():
                    return
                if heard is not None:
                    with self.lock:
                        self.watch.hear(heard)
        except GraphnavError as error:
            self.failure = one_line(error)
