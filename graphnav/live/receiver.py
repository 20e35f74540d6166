"""Listening: a thread that owns the LCM object and keeps the newest messages of every input."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Iterable
from functools import partial
from typing import NamedTuple

from graphnav.bus import Bus
from graphnav.errors import BusError

_POLL_S = 0.05


class Arrival(NamedTuple):
    """A message as it came: its bytes, and when, in monotonic seconds."""

    data: bytes
    at_s: float


class Mailbox:
    """The newest messages of one channel that begin with the right fingerprint.

    One thread fills it, another one empties it. ``wrong_type`` and ``overflowed`` count what was not kept.
    """

    def __init__(self, fingerprint: bytes, max_messages: int) -> None:
        self._fingerprint = fingerprint
        self._kept: deque[Arrival] = deque()
        self._max_messages = max_messages
        self.wrong_type = 0
        self.overflowed = 0

    def put(self, data: bytes, at_s: float) -> bool:
        """Keep a message; return whether it has the right type."""
        if data[:8] != self._fingerprint:
            self.wrong_type += 1
            return False
        self._kept.append(Arrival(data, at_s))
        if len(self._kept) > self._max_messages:
            try:
                self._kept.popleft()
                self.overflowed += 1
            except IndexError:  # the other thread took it in between
                pass
        return True

    def take(self) -> list[Arrival]:
        """Return what came since the last time, oldest first."""
        taken = []
        while self._kept:
            taken.append(self._kept.popleft())
        return taken


class Receiver:
    """Listens on a URL and fills mailboxes, by LCM channel; ``wake`` is set whenever something came.

    Raises BusError where LCM cannot be opened.
    """

    def __init__(self, url: str, mailboxes: Iterable[tuple[str, Mailbox]], wake: threading.Event) -> None:
        self._wake = wake
        self._ending = threading.Event()
        self._bus = Bus(url)
        for channel, mailbox in mailboxes:
            self._bus.subscribe(channel, partial(self._hear, mailbox))
        self._thread = threading.Thread(target=self._serve, name="graphnav-receiver", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop listening."""
        self._ending.set()
        self._thread.join()

    def _hear(self, mailbox: Mailbox, _channel: str, data: bytes) -> None:
        if mailbox.put(data, time.monotonic()):
            self._wake.set()

    def _serve(self) -> None:
        while not self._ending.is_set():
            try:
                self._bus.handle(_POLL_S)
            except (BusError, OSError, RuntimeError):
                self._ending.wait(_POLL_S)
        self._bus.close()
