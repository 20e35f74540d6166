"""One channel of the page: its account, its newest message, and the small ones that plots need."""

from __future__ import annotations

from collections import deque

from graphnav.core.record import ChannelAccount, Clock, Kind
from graphnav.watch.spy import Received

SMALL_BYTES = 1024
"""Messages up to this size are stored for plots."""
_MAX_HISTORY = 600
_MAX_HISTORY_BYTES = 65_536


class WatchedChannel(ChannelAccount):
    """The account and the messages of one channel, which its messages number from 1.

    ``newest``: the newest complete message, unless it is too large; ``history``: the newest small ones with their
    numbers.
    """

    def __init__(self, name: str, announced_type: str | None = None, clock: Clock | None = None) -> None:
        super().__init__(name, announced_type, clock)
        self.newest: Received | None = None
        self.is_too_large = False
        self.history: deque[tuple[int, Received]] = deque()
        self._history_bytes = 0
        self._noted = 0

    def keep_small(self, received: Received) -> None:
        """Store the message that was counted last, if it is small."""
        if len(received.data) > SMALL_BYTES:
            return
        self.history.append((self.count, received))
        self._history_bytes += len(received.data)
        while len(self.history) > _MAX_HISTORY or self._history_bytes > _MAX_HISTORY_BYTES:
            self._history_bytes -= len(self.history.popleft()[1].data)

    def note_undecodable(self, number: int) -> None:
        """Count a message that is complete and cannot be decoded, once."""
        if number != self._noted:
            self._noted = number
            self.undecodable += 1

    def change_type(self, kind: Kind) -> None:
        """Take the type of a message as that of the channel; forget the small messages of another type."""
        super().change_type(kind)
        self.history.clear()
        self._history_bytes = 0
