"""A receive thread that waits only for the network."""

from __future__ import annotations

import threading

from graphnav.core.bus import Bus, Handler
from graphnav.core.errors import BusError

_POLL_S = 0.05
_MAX_WAITING = 50_000
"""Messages that LCM queues for this thread: bounds memory, whatever is sent."""


class Listener:
    """Receives every message of a group: ``take(channel, data)`` is called in the receive thread.

    Raises BusError if LCM cannot be opened.
    """

    def __init__(self, url: str, take: Handler) -> None:
        self._ending = threading.Event()
        self._bus = Bus(url)
        self._bus.subscribe_all(take, max_waiting=_MAX_WAITING)
        self._thread = threading.Thread(target=self._serve, name="graphnav-listener", daemon=True)

    def start(self) -> None:
        """Start the receive thread."""
        self._thread.start()

    def dropped_packets(self) -> int:
        """Return the number of packets that the kernel dropped at this listener's socket."""
        return self._bus.dropped_packets()

    def close(self) -> None:
        """Stop after all messages that had arrived were handed over."""
        self._ending.set()
        if self._thread.is_alive():
            self._thread.join()

    def _serve(self) -> None:
        while not self._ending.is_set():
            self._receive(_POLL_S)
        for _ in range(_MAX_WAITING):
            if not self._receive(0.0):
                break
        self._bus.close()

    def _receive(self, timeout_s: float) -> bool:
        """Wait for a message and hand it over; return whether one arrived."""
        try:
            return self._bus.handle(timeout_s)
        except (BusError, OSError, RuntimeError):
            self._ending.wait(_POLL_S)
            return False
