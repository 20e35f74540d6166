"""A log as a notebook shows it: its channels, and what is lost."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from pathlib import Path

from graphnav.api.log_channel import LogChannel
from graphnav.errors import shown_name

_HEADINGS = ("channel", "type", "messages", "rate [Hz]", "from [s]", "to [s]")


def log_html(path: Path, channels: Iterable[LogChannel], damage: Iterable[str]) -> str:
    """Return HTML in which names that other programs chose are text."""
    head = "".join(f"<th>{heading}</th>" for heading in _HEADINGS)
    lost = "".join(f"<p>{escape(line)}</p>" for line in damage)
    return f"<p>{escape(str(path))}</p>{lost}<table><tr>{head}</tr>{''.join(map(_row, channels))}</table>"


def _row(channel: LogChannel) -> str:
    texts = (escape(shown_name(channel.name)), escape(channel.type_name), str(channel.n_messages))
    numbers = (f"{channel.rate_hz:.4g}", f"{channel.first_s:.2f}", f"{channel.last_s:.2f}")
    return f"<tr>{''.join(f'<td>{cell}</td>' for cell in (*texts, *numbers))}</tr>"
