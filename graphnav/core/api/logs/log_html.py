"""Show a log in a notebook: its channels and losses."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from markupsafe import Markup

from graphnav.core.api.logs.log_channel import LogChannel
from graphnav.core.errors import shown_name
from graphnav.core.render.html_templates import rendered


def log_html(path: Path, channels: Iterable[LogChannel], damage: Iterable[str]) -> Markup:
    """Return HTML in which names that other programs chose are text."""
    named = [(shown_name(channel.name), channel) for channel in channels]
    return rendered("graphnav.core.api", "log.html", path=path, channels=named, damage=damage)
