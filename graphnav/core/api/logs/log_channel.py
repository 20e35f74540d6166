"""A channel of a log and its messages; all channels as HTML, for a notebook."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from markupsafe import Markup

from graphnav.core.errors import shown_name
from graphnav.core.html_templates import rendered
from graphnav.core.messages import Message
from graphnav.core.tables import Table

_NUMBERS = ("messages", "rate [Hz]", "from [s]", "to [s]")


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


def log_html(path: Path, channels: Iterable[LogChannel], damage: Iterable[str]) -> Markup:
    """Return HTML in which names that other programs chose are text."""
    rows = [_cells(channel) for channel in channels]
    table = Table.plain(("channel", "type", *_NUMBERS), rows, right=_NUMBERS).html("notebook")
    return rendered("graphnav.core.api", "log.html", path=path, table=table, damage=damage)


def _cells(channel: LogChannel) -> tuple[object, ...]:
    rate = f"{channel.rate_hz:.4g}" if channel.n_messages > 1 else ""
    times = (f"{channel.first_s:.2f}", f"{channel.last_s:.2f}")
    return shown_name(channel.name), channel.type_name, channel.n_messages, rate, *times
