"""Counts that the sending process writes and the run reads, in shared memory."""

from __future__ import annotations

import mmap
import os
import struct
import threading
from typing import NamedTuple

_LAYOUT = struct.Struct("=5q")


class Counts(NamedTuple):
    """Counts since the start of the process, over all channels.

    ``forwarded`` commands and ``stops`` were sent; ``failed`` messages were refused by the network (not included in the
    two); ``overtaken`` commands were replaced by newer ones before they were forwarded; ``late`` ones had waited for
    longer than ``max_age_s`` and were not forwarded.
    """

    forwarded: int = 0
    stops: int = 0
    failed: int = 0
    overtaken: int = 0
    late: int = 0


class SharedCounts:
    """A few bytes of memory that two processes share through a file descriptor; one writes, the other reads."""

    def __init__(self, fd: int) -> None:
        self._memory = mmap.mmap(fd, _LAYOUT.size)
        self._last: Counts | None = None
        self._lock = threading.Lock()

    @classmethod
    def new_file(cls) -> int:
        """Return the descriptor of a memory file that holds counts of zero; the caller closes it."""
        fd = os.memfd_create("graphnav-motors")
        os.truncate(fd, _LAYOUT.size)
        return fd

    def read(self) -> Counts:
        """Return the counts written last, or last before `close`."""
        with self._lock:
            return self._last or Counts(*_LAYOUT.unpack_from(self._memory))

    def write(self, counts: Counts) -> None:
        """Publish ``counts`` to the reader."""
        _LAYOUT.pack_into(self._memory, 0, *counts)

    def close(self) -> None:
        """Unmap the memory and keep the counts written last."""
        with self._lock:
            if self._last is None:
                self._last = Counts(*_LAYOUT.unpack_from(self._memory))
                self._memory.close()
