"""A program that listens, as others on the robot do."""

from __future__ import annotations

import time
from collections.abc import Callable

from graphnav.core.bus import Bus


class Listener:
    """Collects the messages of a group."""

    def __init__(self, url: str) -> None:
        self.received: list[tuple[str, bytes]] = []
        self._bus = Bus(url)
        self._bus.subscribe_all(lambda channel, data: self.received.append((channel, data)))

    def wait_for(self, n: int) -> list[tuple[str, bytes]]:
        """Return what was received once there are ``n`` messages, or after half a minute."""
        self.listen_until(lambda: len(self.received) >= n)
        return self.received

    def listen_until(self, is_over: Callable[[], bool]) -> None:
        """Listen until a condition holds, half a minute at most."""
        end_s = time.monotonic() + 30
        while not is_over() and time.monotonic() < end_s:
            self._bus.handle(0.02)

    def close(self) -> None:
        """Listen no more."""
        self._bus.close()
