"""File names for channels with arbitrary names."""

from __future__ import annotations

from collections.abc import Iterable
from urllib.parse import quote

_MAX_CHARACTERS = 200


def file_names(channels: Iterable[str], suffix: str) -> dict[str, str]:
    """Return a unique file name for each channel: its name with special characters escaped.

    Characters with a meaning in shells are written as ``%2F``; too long names are cut and numbered.
    """
    names: dict[str, str] = {}
    for number, channel in enumerate(channels):
        name = quote(channel, safe="")
        names[channel] = (name if len(name) <= _MAX_CHARACTERS else f"{name[:_MAX_CHARACTERS]}~{number}") + suffix
    return names
