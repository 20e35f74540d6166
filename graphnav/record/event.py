"""The events of an LCM log and how they lie in the file.

Sync word 0xEDA1DA01, int64 number, int64 microseconds, int32 length of the channel, int32 length of the data, channel,
data; big-endian, nothing before, between or behind them.
"""

from __future__ import annotations

import os
import struct
from pathlib import Path
from typing import NamedTuple

from graphnav.errors import LogError

SYNC = 0xEDA1DA01
HEADER = struct.Struct(">Iqqii")


class Event(NamedTuple):
    """What was published when, on which channel."""

    channel: str
    utime: int
    data: bytes


class Entry(NamedTuple):
    """Where an event's data lie in the file."""

    channel: str
    utime: int
    start: int
    stop: int


class Torn(NamedTuple):
    """The end of a log whose last event is not whole: where that begins and how many bytes there are."""

    at: int
    n_bytes: int

    def __str__(self) -> str:
        return f"the last event, {self.n_bytes} bytes from byte {self.at}, is not whole"


class Damaged(NamedTuple):
    """Bytes between the events of a log that are not an event: where they begin and how many there are."""

    at: int
    n_bytes: int

    def __str__(self) -> str:
        return f"{self.n_bytes} bytes from byte {self.at} are not an event"


class LogFile:
    """The bytes of a log, read where they are asked for: a mapped file would count as memory of the process."""

    def __init__(self, path: Path) -> None:
        self._fd = -1
        try:
            self._fd = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
            self.size = os.fstat(self._fd).st_size
            self.read(0, 1)
        except OSError as error:
            raise LogError(f"{path}: {error.strerror}") from error

    def read(self, start: int, stop: int) -> bytes:
        """Return the bytes from ``start`` to before ``stop``, fewer where the file ends."""
        return os.pread(self._fd, stop - start, start)

    def close(self) -> None:
        """Close the file; idempotent."""
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1

    def __del__(self) -> None:
        self.close()
