"""A well-behaved channel among hostile ones."""

from __future__ import annotations

import threading
import time
from types import TracebackType
from typing import Self

from graphnav.core.bus import Bus
from graphnav.core.codec import encode
from graphnav.core.messages import Twist

CHANNEL = "sane.twist"
RATE_HZ = 20.0


class SaneSender:
    """While entered, publishes commands at 20 Hz, stamped with the time of day; ``sent`` counts them."""

    def __init__(self, url: str) -> None:
        self._url = url
        self.sent = 0
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._send, daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.stop()

    def stop(self) -> None:
        """Cease; does nothing the second time."""
        self._ending.set()
        self._thread.join()

    def _send(self) -> None:
        bus = Bus(self._url)
        begin_s = time.monotonic()
        while not self._ending.wait(max(0.0, begin_s + self.sent / RATE_HZ - time.monotonic())):
            bus.publish(CHANNEL, encode(Twist(0.1, 0.0), time.time_ns() // 1000, self.sent))
            self.sent += 1
        bus.close()
