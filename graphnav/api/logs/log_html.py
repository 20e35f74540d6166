"""A log as a notebook shows it: its channels, and what is lost."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from pathlib import Path

from graphnav.api.logs.log_channel import LogChannel
from graphnav.errors import shown_name

_HEADINGS = ("channel", "type", "messages", "rate [Hz]", "from [s]", "to [s]")
_N_NAMES = 2
"""So many columns are words."""


def log_html(path: Path, channels: Iterable[LogChannel], damage: Iterable[str]) -> str:
    """Return HTML in which names that other programs chose are text."""
    head = "".join(_cell(heading, "th", is_left=place < _N_NAMES) for place, heading in enumerate(_HEADINGS))
    lost = "".join(f"<p>{escape(line)}</p>" for line in damage)
    return f"<p>{escape(str(path))}</p>{lost}<table><tr>{head}</tr>{''.join(map(_row, channels))}</table>"


def _row(channel: LogChannel) -> str:
    names = (escape(shown_name(channel.name)), escape(channel.type_name))
    rate = f"{channel.rate_hz:.4g}" if channel.n_messages > 1 else ""
    numbers = (str(channel.n_messages), rate, f"{channel.first_s:.2f}", f"{channel.last_s:.2f}")
    cells = (*(_cell(name, "td", is_left=True) for name in names), *(_cell(number, "td") for number in numbers))
    return f"<tr>{''.join(cells)}</tr>"


def _cell(text: str, tag: str, *, is_left: bool = False) -> str:
    style = ' style="text-align:left"' if is_left else ""
    return f"<{tag}{style}>{text}</{tag}>"
