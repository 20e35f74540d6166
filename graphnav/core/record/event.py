"""The events of an LCM log and their file format.

Sync word 0xEDA1DA01, int64 number, int64 microseconds, int32 length of the channel, int32 length of the data, channel,
data; big-endian, without header, padding or trailer.
"""

from __future__ import annotations

import os
import struct
from pathlib import Path
from typing import NamedTuple

from graphnav.core.errors import LogError
from graphnav.core.machine.files import open_regular
from graphnav.core.machine.system import read_at

SYNC = 0xEDA1DA01
HEADER = struct.Struct(">Iqqii")


class Event(NamedTuple):
    """A logged message: channel, timestamp (microseconds), data."""

    channel: str
    utime: int
    data: bytes


class Entry(NamedTuple):
    """The position of an event's data in the file."""

    channel: str
    utime: int
    start: int
    stop: int


class TruncatedEvent(NamedTuple):
    """An incomplete last event: its position and number of bytes."""

    at: int
    n_bytes: int

    def __str__(self) -> str:
        return f"the last event, {self.n_bytes} bytes from byte {self.at}, is truncated"


class Damaged(NamedTuple):
    """Bytes between events that are not an event: their position and number."""

    at: int
    n_bytes: int

    def __str__(self) -> str:
        return f"{self.n_bytes} bytes from byte {self.at} are not an event"


class LogFile:
    """The bytes of a log, read on demand: a mapped file would count as memory of the process."""

    def __init__(self, path: Path | int) -> None:
        """Open a file by its path, or by a descriptor, which is duplicated; raises LogError if it cannot be read."""
        self._fd = -1
        try:
            self._fd = os.dup(path) if isinstance(path, int) else open_regular(path)
            self.size = os.fstat(self._fd).st_size
            self.read(0, 1)
        except OSError as error:
            raise LogError(f"{path}: {error.strerror}") from error

    def read(self, start: int, stop: int) -> bytes:
        """Return the bytes from ``start`` to before ``stop``, fewer at the end of the file."""
        return read_at(self._fd, stop - start, start)

    def close(self) -> None:
        """Close the file; idempotent."""
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1

    def __del__(self) -> None:
        self.close()
