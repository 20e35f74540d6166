"""Show a log in a notebook: its channels and losses."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from markupsafe import Markup

from graphnav.core.api.logs.log_channel import LogChannel
from graphnav.core.errors import shown_name
from graphnav.core.html_templates import rendered
from graphnav.core.tables import html_table, plain_table

_NUMBERS = ("messages", "rate [Hz]", "from [s]", "to [s]")


def log_html(path: Path, channels: Iterable[LogChannel], damage: Iterable[str]) -> Markup:
    """Return HTML in which names that other programs chose are text."""
    rows = [_cells(channel) for channel in channels]
    table = html_table(plain_table(("channel", "type", *_NUMBERS), rows, right=_NUMBERS), "notebook")
    return rendered("graphnav.core.api", "log.html", path=path, table=table, damage=damage)


def _cells(channel: LogChannel) -> tuple[object, ...]:
    rate = f"{channel.rate_hz:.4g}" if channel.n_messages > 1 else ""
    times = (f"{channel.first_s:.2f}", f"{channel.last_s:.2f}")
    return shown_name(channel.name), channel.type_name, channel.n_messages, rate, *times
