"""What a log says of one channel, and one of its messages."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from graphnav.messages import Message


class Sample(NamedTuple):
    """One message of a log."""

    time_s: float
    """Seconds since the log began."""
    message: Any
    """The message (`Flow`, `Twist`, ...); a dict of LCM fields where graphnav has no class for the type."""


@dataclass(frozen=True)
class LogChannel:
    """What a log holds of one channel."""

    name: str
    type_name: str
    """``package.type_t``; empty where the type is not installed: its messages can be counted, not read."""
    message: type[Message] | None
    """The class of its messages; None where they are read as dicts."""
    n_messages: int
    first_s: float
    last_s: float

    @property
    def rate_hz(self) -> float:
        """The mean rate, 0 for a single message."""
        span_s = self.last_s - self.first_s
        return (self.n_messages - 1) / span_s if span_s > 0 else 0.0
