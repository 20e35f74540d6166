"""Count messages that cannot be shown by reason, and report them when a count has doubled."""

from __future__ import annotations

from collections.abc import Iterator
from enum import Enum

from graphnav.core.errors import shown_name

_MAX_LOSSES = 256


class Reason(Enum):
    """The reasons why messages are not shown, as templates of lines of text."""

    UNKNOWN_TYPE = "channel '{channel}': its type is not installed, messages not shown: {n}"
    UNDECODABLE = "channel '{channel}': messages that cannot be decoded: {n}"
    UNDRAWN = "channel '{channel}': pictures that cannot be drawn: {n}: {why}"
    UNTRACKED = "messages of further channels, not shown: {n}"
    TOO_FAST = "messages that came faster than they can be shown: {n}"
    DROPPED = "packets that the kernel dropped before they could be received: {n}"
    FEED = "{why}"


class Losses:
    """Counts of at most 256 reasons and channels."""

    def __init__(self) -> None:
        self._counts: dict[tuple[Reason, str], int] = {}
        self._causes: dict[tuple[Reason, str], str] = {}
        self._due: set[tuple[Reason, str]] = set()

    def add(self, reason: Reason, channel: str = "", why: str = "", n: int = 1) -> None:
        """Count messages."""
        key = reason, channel
        if key not in self._counts and len(self._counts) >= _MAX_LOSSES:
            key = reason, "..."
        before = self._counts.get(key, 0)
        self._counts[key], self._causes[key] = before + n, why
        if (before + n).bit_length() > before.bit_length():
            self._due.add(key)

    def forget_messages(self) -> None:
        """Reset the counts of messages, which are played again after a jump in a log."""
        for key in [key for key in self._counts if key[0] is not Reason.FEED]:
            del self._counts[key], self._causes[key]
            self._due.discard(key)

    def due(self) -> list[str]:
        """Return lines for new reasons, and for counts that have doubled since the last report."""
        keys, self._due = self._due, set()
        return list(self._texts(key for key in self._counts if key in keys)) if keys else []

    def all(self) -> list[str]:
        """Return lines for all losses so far."""
        return list(self._texts(iter(self._counts)))

    def _texts(self, keys: Iterator[tuple[Reason, str]]) -> Iterator[str]:
        for key in keys:
            reason, channel = key
            yield reason.value.format(channel=shown_name(channel), n=self._counts[key], why=self._causes[key])
