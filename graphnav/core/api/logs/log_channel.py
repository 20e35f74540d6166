"""Describe a channel of a log and its messages."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from graphnav.core.messages import Message


class Sample(NamedTuple):
    """One message of a log."""

    time_s: float
    """Seconds from the start of the log."""
    message: Any
    """The message (`Flow`, `Twist`, ...); a dict of LCM fields if graphnav has no class for the type."""


@dataclass(frozen=True)
class LogChannel:
    """A channel of a log."""

    name: str
    type_name: str
    """``package.type_t``; empty if the type is not installed: its messages can be counted, not read."""
    message: type[Message] | None
    """The class of its messages; None if they are read as dicts."""
    n_messages: int
    first_s: float
    last_s: float

    @property
    def rate_hz(self) -> float:
        """The mean rate, 0 for a single message."""
        span_s = self.last_s - self.first_s
        return (self.n_messages - 1) / span_s if span_s > 0 else 0.0
