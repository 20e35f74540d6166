"""A thread that is stopped by its owner, and one that receives a multicast group until then."""

from __future__ import annotations

import threading
from collections.abc import Callable

from graphnav import GraphnavError
from graphnav.watch.feed.feed import Feed, Received

_POLL_S = 0.05
_MAX_LEFT = 50_000
"""Messages that are handed over after the end, if that many had arrived before."""


class StoppableThread(threading.Thread):
    """A thread that runs ``work``, which returns soon after ``stopping`` is set."""

    def __init__(self, work: Callable[[], None], name: str) -> None:
        super().__init__(target=work, name=name, daemon=True)
        self.stopping = threading.Event()

    def stop(self) -> None:
        """Stop, and wait until the work has returned."""
        self.stopping.set()
        if self.is_alive():
            self.join()


class LiveFeed:
    """Hands every message of a live feed to ``take`` as it arrives, in a thread that waits for nothing else.

    It may start before any publisher, and outlives publishers. ``take`` is called with ``lock`` held. ``failure``: why
    nothing is received, empty while it is; ``wake`` is called when it has changed.
    """

    def __init__(
        self,
        feed: Feed,
        take: Callable[[Received], None],
        wake: Callable[[], None] = lambda: None,
        name: str = "graphnav-feed",
    ) -> None:
        self.name, self.failure = feed.name, ""
        self.lock = threading.Lock()
        self._feed, self._take, self._wake = feed, take, wake
        self._thread = StoppableThread(self._listen, name)

    def open(self) -> None:
        """Join the group now, not in the thread; raises as `Feed.open` does."""
        self._feed.open(self._receive)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def close(self) -> None:
        """Stop after all messages that had arrived were handed over; leave the group."""
        self._thread.stop()
        self._feed.close()

    @property
    def losses(self) -> str:
        """A phrase about what another computer has dropped in place of sending it; empty if there is nothing."""
        return self._feed.losses

    def dropped_packets(self) -> int:
        """Return the number of packets dropped by the kernel."""
        return self._feed.dropped_packets()

    def _listen(self) -> None:
        try:
            self.open()
        except (GraphnavError, OSError) as error:
            self._fail(str(error))
            return
        while not self._thread.stopping.is_set():
            self._handle(_POLL_S)
        for _ in range(_MAX_LEFT):
            if not self._handle(0.0):
                break

    def _handle(self, timeout_s: float) -> bool:
        """Wait for a message and hand it over; return whether one arrived."""
        try:
            has_arrived = self._feed.handle(timeout_s)
        except (GraphnavError, OSError, RuntimeError) as error:
            self._fail(str(error))
            self._thread.stopping.wait(_POLL_S)
            return False
        self._fail(self._feed.failure)
        return has_arrived

    def _fail(self, why: str) -> None:
        if why != self.failure:
            self.failure = why
            self._wake()

    def _receive(self, received: Received) -> None:
        with self.lock:
            self._take(received)
