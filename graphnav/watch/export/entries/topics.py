"""Name the channels of a log in viewers whose names have slashes."""

from __future__ import annotations

import re
from collections.abc import Iterable

from graphnav.core.errors import shown_name

PICTURE = "picture"
"""The last part of the topic of a channel's pictures."""
BEAMS = "beams"
"""The last part of the topic of a channel's scans."""
_BELOW = (PICTURE, BEAMS)

_STAGE_PORT = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\.[A-Za-z_][A-Za-z0-9_]*")


def parts_of(channel: str) -> tuple[str, ...]:
    """Return the parts of a channel's name: stage and port, or the complete name."""
    return tuple(channel.split(".")) if _STAGE_PORT.fullmatch(channel) else (channel,)


class Topics:
    """A topic for each channel: ``/plane/plane`` for ``plane.plane``, and below it one for its pictures or scans.

    All topics are unique and differ from the ``reserved`` ones, for any channel names; control characters are escaped.
    """

    def __init__(self, reserved: Iterable[str]) -> None:
        self._taken = set(reserved)
        self._topics: dict[str, str] = {}

    def of(self, channel: str) -> str:
        """Return the topic of a channel's scalars."""
        if channel not in self._topics:
            topic = "/" + shown_name("/".join(parts_of(channel))).lstrip("/")
            while not self._taken.isdisjoint(_with_below(topic)):
                topic += "_"
            self._taken.update(_with_below(topic))
            self._topics[channel] = topic
        return self._topics[channel]

    def picture_of(self, channel: str) -> str:
        """Return the topic of a channel's pictures."""
        return f"{self.of(channel)}/{PICTURE}"

    def beams_of(self, channel: str) -> str:
        """Return the topic of a channel's scans."""
        return f"{self.of(channel)}/{BEAMS}"

    def forget(self, channel: str) -> None:
        """Release the topics of a channel for other channels."""
        topic = self._topics.pop(channel, None)
        if topic is not None:
            self._taken.difference_update(_with_below(topic))


def _with_below(topic: str) -> tuple[str, ...]:
    return topic, *(f"{topic}/{part}" for part in _BELOW)
