"""Count the published messages by channel."""

from __future__ import annotations

from collections import Counter


class MessageCounts:
    """A sink that counts messages."""

    def __init__(self) -> None:
        self._counts: Counter[str] = Counter()

    def write(self, channel: str, _utime: int, _data: bytes) -> None:
        """Count one message."""
        self._counts[channel] += 1

    def of(self, channel: str) -> int:
        """Return the number of messages on a channel."""
        return self._counts[channel]
