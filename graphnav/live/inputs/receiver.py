"""Receive messages in a thread that owns the LCM object and keeps the newest of every input."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable, Collection, Iterable
from contextlib import closing, suppress
from functools import partial
from typing import NamedTuple, Protocol

from graphnav.core.bus import Bus
from graphnav.core.errors import BusError

_POLL_S = 0.05
SCAN_S = 1.0
"""Duration of a scan."""
_MAX_SCANNED = 16
"""Maximum number of channels that a scan keeps: their names are others'."""
_MAX_SCAN_QUEUE = 256
NEWEST = 8
"""Maximum number of pending messages if only the newest counts: images of 640x480 have 0.3 to 0.9 MB."""
MAX_OF_OTHERS = 8
"""Maximum number of pending messages of other writers."""


class Arrival(NamedTuple):
    """A received message: its bytes, and its arrival in monotonic seconds."""

    data: bytes
    at_s: float


def _anyone(_data: bytes, _at_s: float) -> bool:
    return True


class Mailbox:
    """The newest messages of one channel that begin with the right fingerprint; those of a topic have none.

    ``is_own``: whether a message is from the accepted writer, by its bytes and its arrival. Messages of others, at most
    8, are kept separately, so that they never displace those of the accepted writer.

    One thread fills it, another one empties it. ``largest_bytes``: size of the largest message. ``wrong_type``,
    ``overflowed`` and ``flooded`` count dropped messages, the last one those of other writers. ``wrong_mark``: the
    first bytes of the last message of another type, which should be a fingerprint. ``heard_s``: arrival of the last
    message, whatever it is, monotonic seconds.
    """

    def __init__(self, fingerprint: bytes, max_messages: int, is_own: Callable[[bytes, float], bool] = _anyone) -> None:
        self._fingerprint = fingerprint
        self._own: deque[Arrival] = deque()
        self._others: deque[Arrival] = deque()
        self._max_messages = max_messages
        self._is_own = is_own
        self.wrong_type = 0
        self.overflowed = 0
        self.flooded = 0
        self.largest_bytes = 0
        self.wrong_mark = b""
        self.heard_s = -math.inf

    def put(self, data: bytes, at_s: float) -> bool:
        """Store a message; return whether it may be used: right type, accepted writer."""
        self.heard_s = at_s
        if not data.startswith(self._fingerprint):
            self.wrong_mark = data[:8]
            self.wrong_type += 1
            return False
        self.largest_bytes = max(self.largest_bytes, len(data))
        if not self._is_own(data, at_s):
            self.flooded += _keep(self._others, Arrival(data, at_s), MAX_OF_OTHERS)
            return False
        self.overflowed += _keep(self._own, Arrival(data, at_s), self._max_messages)
        return True

    def take(self) -> list[Arrival]:
        """Return the messages since the last call, oldest first."""
        taken = [kept.popleft() for kept in (self._own, self._others) for _ in range(len(kept))]
        return sorted(taken, key=lambda arrival: arrival.at_s)


def _keep(kept: deque[Arrival], arrival: Arrival, max_messages: int) -> bool:
    """Store a message; return whether the oldest one was dropped for it."""
    kept.append(arrival)
    if len(kept) <= max_messages:
        return False
    try:
        kept.popleft()
    except IndexError:  # taken by the other thread in the meantime
        return False
    return True


class Takes(Protocol):
    """A receiver of the messages of a channel."""

    def put(self, data: bytes, at_s: float) -> bool:
        """Handle a message; return whether it may be used."""


class PacketLoss(NamedTuple):
    """How many packets the kernel dropped because they came faster than they were read, and the buffer it granted."""

    packets: int
    buffer_bytes: int


class Receiver:
    """Listens on a URL and fills mailboxes by LCM channel; ``wake`` is set on every arrival.

    ``url``: as it is used, with its defaults.

    Raises BusError if LCM cannot be opened.
    """

    def __init__(self, url: str, mailboxes: Iterable[tuple[str, Takes]], wake: threading.Event) -> None:
        self._wake = wake
        self._ending = threading.Event()
        self._bus = Bus(url)
        self.url = self._bus.url
        for channel, mailbox in mailboxes:
            self._bus.subscribe(channel, partial(self._hear, mailbox))
        self._buffer_bytes = self._bus.receive_buffer_bytes()
        self._dropped_packets = 0
        self._thread = threading.Thread(target=self._serve, name="graphnav-receiver", daemon=True)
        self._thread.start()

    def packet_loss(self) -> PacketLoss:
        """Return the packets dropped so far."""
        self._dropped_packets = max(self._dropped_packets, self._bus.dropped_packets())
        return PacketLoss(self._dropped_packets, self._buffer_bytes)

    def close(self) -> None:
        """Stop listening."""
        self._ending.set()
        self._thread.join()

    def _hear(self, mailbox: Takes, _channel: str, data: bytes) -> None:
        if mailbox.put(data, time.monotonic()):
            self._wake.set()

    def _serve(self) -> None:
        while not self._ending.is_set():
            try:
                self._bus.handle(_POLL_S)
            except (BusError, OSError, RuntimeError):
                self._ending.wait(_POLL_S)
        self._bus.close()


class TypeScan:
    """Listens to every channel of a URL for a second, in a thread, for messages of some types.

    It has an LCM object of its own: the receiver of a run does not hear what its stages do not read.
    """

    def __init__(self, url: str, fingerprints: Collection[bytes]) -> None:
        self._url, self._fingerprints = url, frozenset(fingerprints)
        self._arrivals: dict[tuple[bytes, str], tuple[int, float, float]] = {}
        """Number, first and last arrival of the messages, by type and channel."""
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._serve, name="graphnav-type-scan", daemon=True)
        self._thread.start()

    @property
    def is_over(self) -> bool:
        """Whether the second has passed."""
        return not self._thread.is_alive()

    def channels(self, fingerprint: bytes) -> dict[str, float]:
        """Return the channels on which messages of a type came, and their rates, Hz."""
        return {
            channel: (n - 1) / (last_s - first_s) if last_s > first_s else n / SCAN_S
            for (mark, channel), (n, first_s, last_s) in self._arrivals.items()
            if mark == fingerprint
        }

    def close(self) -> None:
        """Stop listening."""
        self._ending.set()
        self._thread.join()

    def _hear(self, channel: str, data: bytes) -> None:
        key, at_s = (data[:8], channel), time.monotonic()
        if key in self._arrivals or (key[0] in self._fingerprints and len(self._arrivals) < _MAX_SCANNED):
            n, first_s, _ = self._arrivals.get(key, (0, at_s, at_s))
            self._arrivals[key] = n + 1, first_s, at_s

    def _serve(self) -> None:
        with suppress(BusError, OSError, RuntimeError), closing(Bus(self._url)) as bus:
            bus.subscribe_all(self._hear, _MAX_SCAN_QUEUE)
            end_s = time.monotonic() + SCAN_S
            while time.monotonic() < end_s and not self._ending.is_set():
                bus.handle(_POLL_S)
