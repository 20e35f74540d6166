"""What the channels of a log are called in viewers whose names have slashes."""

from __future__ import annotations

import re
from collections.abc import Iterable

_STAGE_PORT = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\.[A-Za-z_][A-Za-z0-9_]*")


def parts_of(channel: str) -> tuple[str, ...]:
    """Return the parts of a channel's name: stage and port, or the name as it is."""
    return tuple(channel.split(".")) if _STAGE_PORT.fullmatch(channel) else (channel,)


def topics_of(channels: Iterable[str]) -> dict[str, str]:
    """Return a topic for each channel, all different: ``/plane/plane`` for ``plane.plane``."""
    topics: dict[str, str] = {}
    for channel in channels:
        topic = "/" + "/".join(parts_of(channel)).lstrip("/")
        while topic in topics.values():
            topic += "_"
        topics[channel] = topic
    return topics
