"""Name the channels of a log in viewers whose names have slashes."""

from __future__ import annotations

import re
from collections.abc import Iterable

from graphnav.core.errors import shown_name

PICTURE = "picture"
"""The last part of the topic of a channel's pictures."""

_STAGE_PORT = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\.[A-Za-z_][A-Za-z0-9_]*")


def parts_of(channel: str) -> tuple[str, ...]:
    """Return the parts of a channel's name: stage and port, or the complete name."""
    return tuple(channel.split(".")) if _STAGE_PORT.fullmatch(channel) else (channel,)


class Topics:
    """A topic for each channel: ``/plane/plane`` for ``plane.plane``, and one below it for its pictures.

    All topics are unique and differ from the ``reserved`` ones, for any channel names; control characters are escaped.
    """

    def __init__(self, reserved: Iterable[str]) -> None:
        self._taken = set(reserved)
        self._topics: dict[str, str] = {}

    def of(self, channel: str) -> str:
        """Return the topic of a channel's scalars."""
        if channel not in self._topics:
            topic = "/" + shown_name("/".join(parts_of(channel))).lstrip("/")
            while not self._taken.isdisjoint((topic, f"{topic}/{PICTURE}")):
                topic += "_"
            self._taken.update((topic, f"{topic}/{PICTURE}"))
            self._topics[channel] = topic
        return self._topics[channel]

    def picture_of(self, channel: str) -> str:
        """Return the topic of a channel's pictures."""
        return f"{self.of(channel)}/{PICTURE}"

    def forget(self, channel: str) -> None:
        """Release the topics of a channel for other channels."""
        topic = self._topics.pop(channel, None)
        if topic is not None:
            self._taken.difference_update((topic, f"{topic}/{PICTURE}"))
