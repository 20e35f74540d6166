"""Names of files for channels, whatever a channel is called."""

from __future__ import annotations

from collections.abc import Iterable
from urllib.parse import quote

_MAX_CHARACTERS = 200


def file_names(channels: Iterable[str], suffix: str) -> dict[str, str]:
    """Return a file name for each channel, all different: its own name, but for characters that a shell would mind.

    Those are written as ``%2F``; what is longer than a file name may be is cut and numbered.
    """
    names: dict[str, str] = {}
    for number, channel in enumerate(channels):
        name = quote(channel, safe="")
        names[channel] = (name if len(name) <= _MAX_CHARACTERS else f"{name[:_MAX_CHARACTERS]}~{number}") + suffix
    return names
