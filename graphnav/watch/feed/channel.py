"""One watched channel: its account, its newest message, the small ones that plots need, messages a second."""

from __future__ import annotations

import math
from collections import deque
from contextlib import suppress
from typing import Any

from graphnav.core.codec import DecodeError
from graphnav.watch.channel_account import ChannelAccount, Clock, Kind
from graphnav.watch.feed.feed import Received

KEPT_MESSAGES = 600
"""The number of small messages stored per channel for plots and paths."""
_SMALL_BYTES = 1024
_MAX_SMALL_BYTES = KEPT_MESSAGES * 512
SECONDS = 60
"""The number of seconds in a `RateHistory`."""


class RateHistory:
    """Message counts of the last 60 complete seconds and of the current one."""

    def __init__(self) -> None:
        self._seconds: deque[int] = deque(maxlen=SECONDS)
        self._second = 0
        self._count = 0
        self._is_empty = True

    def add(self, at_s: float) -> None:
        """Count a message; a message older than the newest is counted with the newest."""
        if self._is_empty and math.isfinite(at_s):
            self._second, self._is_empty = math.floor(at_s), False
        self._advance(at_s)
        self._count += 1

    def counts(self, now_s: float) -> list[int]:
        """Return the counts of complete seconds up to now, oldest first: at most 60, none before the first message."""
        self._advance(now_s)
        return list(self._seconds)

    def _advance(self, to_s: float) -> None:
        """Close elapsed seconds; a clock jump closes at most 60."""
        if self._is_empty or not math.isfinite(to_s) or to_s < self._second + 1:
            return
        self._seconds.append(self._count)
        self._count = 0
        missed = math.floor(to_s) - self._second - 1
        self._seconds.extend([0] * min(missed, SECONDS))
        self._second = math.floor(to_s)


class WatchedChannel(ChannelAccount):
    """The account and the messages of one channel, which its messages number from 1.

    ``newest``: the newest complete message of a known type, None before the first, and where ``is_too_large``: there
    was no room for it. ``history``: the newest messages of at most 1024 bytes with their numbers, up to 600 and 307 kB.
    ``rates``: messages in each of the last seconds.
    """

    def __init__(self, name: str, announced_type: str | None = None, clock: Clock | None = None) -> None:
        super().__init__(name, announced_type, clock)
        self.newest: Received | None = None
        self.is_too_large = False
        self.history: deque[tuple[int, Received]] = deque()
        self.n_small_bytes = 0
        self.rates = RateHistory()
        self._decoded: tuple[Received, dict[str, Any] | None] | None = None
        self._noted = 0

    @property
    def n_newest_bytes(self) -> int:
        """The bytes of the stored newest message."""
        return len(self.newest.data) if self.newest is not None else 0

    def keep(self, received: Received, room_bytes: int, small_room_bytes: int) -> None:
        """Store the complete message that was counted last.

        ``room_bytes``: for the newest message, ``small_room_bytes``: for small ones beyond those that it replaces.
        """
        n_bytes = len(received.data)
        self.is_too_large = n_bytes > room_bytes
        self.newest = None if self.is_too_large else received
        if n_bytes > _SMALL_BYTES:
            return
        max_bytes = min(_MAX_SMALL_BYTES, self.n_small_bytes + max(0, small_room_bytes))
        self.history.append((self.count, received))
        self.n_small_bytes += n_bytes
        while len(self.history) > KEPT_MESSAGES or self.n_small_bytes > max_bytes:
            self.n_small_bytes -= len(self.history.popleft()[1].data)

    def change_type(self, kind: Kind) -> None:
        """Take the type of a message as that of the channel; forget messages of another type."""
        super().change_type(kind)
        self.newest = None
        self.history.clear()
        self.n_small_bytes = 0

    def note_undecodable(self, number: int) -> None:
        """Count a message that is complete and cannot be decoded, once."""
        if number != self._noted:
            self._noted = number
            self.undecodable += 1

    @property
    def values(self) -> dict[str, Any] | None:
        """The fields of the newest message, which are decoded on access; None without one."""
        newest = self.newest
        if newest is None or self.kind is None:
            return None
        if self._decoded is None or self._decoded[0] is not newest:
            self._decoded = newest, None
            with suppress(DecodeError):  # sizes beyond what numpy can shape
                self._decoded = newest, self.kind.codec.decode(newest.data)
        return self._decoded[1]
