"""Write messages of graphnav as a ROS 2 bag."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterable
from pathlib import Path

from graphnav.core.messages import Message
from graphnav.core.record.bags.library import Cdr, StorageWriter
from graphnav.core.record.bags.to_ros import WRITTEN, RosMessages

_END_US = 1_000_000 << 31
"""Where the stamps of ROS end, in 2038."""
_NOT_IN_NAMES = re.compile(r"[^A-Za-z0-9_/]|/(?=/|$)")


class BagWriter:
    """A new bag in a folder that does not exist; ``storage``: ``mcap`` or ``sqlite3``.

    A channel ``stage.port`` becomes the topic ``/stage/port``; what ROS has not in names becomes ``_``.

    Raises
    ------
    UserError
        The extra ``bags`` is not installed.
    OSError
        The disk refuses it.
    """

    def __init__(self, folder: Path, storage: str) -> None:
        self._cdr = Cdr()
        self._ros = RosMessages(self._cdr)
        self._file = StorageWriter(folder, storage, self._cdr)
        self._topics: dict[str, str] = {}

    @staticmethod
    def takes(kind: type[Message] | None) -> bool:
        """Whether messages of a type have a standard ROS type."""
        return kind in WRITTEN

    def write(self, channel: str, logged_us: int, utime: int, message: Message) -> bool:
        """Append a message, recorded at ``logged_us``, with its own stamp; raises OSError if the disk refuses it.

        Returns false, without writing, for a time or a number that the ROS type cannot hold.
        """
        if not (0 <= logged_us < _END_US and 0 <= utime < _END_US):
            return False
        if channel not in self._topics:
            self._topics[channel] = topic_of(channel, self._topics.values())
        writing = WRITTEN[type(message)]
        try:
            data = self._cdr.encode(writing.convert(self._ros, message, utime))
        except (struct.error, OverflowError):  # a number beyond float32
            return False
        self._file.write(self._topics[channel], writing.ros_type, logged_us * 1000, data)
        return True

    def close(self, *, is_complete: bool) -> None:
        """Write the index and the metadata; of an incomplete bag only close the files."""
        self._file.close(is_complete=is_complete)


def topic_of(channel: str, taken: Iterable[str]) -> str:
    """Return the name of a channel's topic, unlike those ``taken``: ``/stage/port`` for ``stage.port``."""
    parts = _NOT_IN_NAMES.sub("_", channel.replace(".", "/").strip("/")).split("/")
    topic = "".join(f"/{part if part[:1].isalpha() or part[:1] == '_' else f'_{part}'}" for part in parts)
    while topic in set(taken):
        topic += "_"
    return topic
