"""A thread that receives a live feed until it is stopped."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import closing

from graphnav import GraphnavError
from graphnav.watch.spy.feed import Feed, Received


class FeedListener:
    """Hands every message of a live feed to ``take``, from a separate thread.

    It may start before any publisher, and outlives publishers. ``fail`` is called with the error that ended the thread
    early.
    """

    def __init__(
        self, feed: Feed, take: Callable[[Received], None], fail: Callable[[GraphnavError | OSError], None], name: str
    ) -> None:
        self._feed, self._take, self._fail = feed, take, fail
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._listen, name=name, daemon=True)

    def start(self) -> None:
        """Start receiving."""
        self._thread.start()

    def close(self) -> None:
        """Stop receiving; return when the thread has ended."""
        self._closing.set()
        if self._thread.is_alive():
            self._thread.join()

    def _listen(self) -> None:
        try:
            with closing(self._feed.listen(None)) as received_all:
                for received in received_all:
                    if self._closing.is_set():
                        return
                    if received is not None:
                        self._take(received)
        except (GraphnavError, OSError) as error:
            self._fail(error)
