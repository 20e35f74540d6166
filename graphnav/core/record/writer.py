"""Write LCM logs that stay readable after crashes and full disks."""

from __future__ import annotations

import errno
import os
import time
from pathlib import Path
from types import TracebackType
from typing import Self

from graphnav.core.errors import LogError
from graphnav.core.machine.system import open_file, write_some
from graphnav.core.record.event import HEADER, SYNC

_FLUSH_BYTES = 1 << 18
_FLUSH_EVENTS = 400
"""Two buffers per event; the kernel accepts 1024 at once."""
_FLUSH_S = 0.5


class LogWriter:
    """An LCM event log whose events have the given timestamps.

    Events are written in one call per 256 kB or half a second, so that a killed process loses at most that much. After
    a write error (disk full or removed) the incomplete event is removed and LogError is raised; the log up to there
    stays complete, and goes on after `resume`.

    Raises OSError if the file cannot be opened at all.
    """

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        self.n_events = 0
        self.last_us: int | None = None
        """The timestamp of the last event, None without one."""
        self._fd = open_file(self.path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        self._waiting: list[bytes] = []
        self._waiting_bytes = 0
        self._complete_bytes = 0
        self._complete_us: int | None = None
        self._flushed_s = time.monotonic()
        self._failure: LogError | None = None

    @property
    def n_bytes(self) -> int:
        """The size of the log, including unflushed events."""
        return self._complete_bytes + self._waiting_bytes

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Append an event; raises LogError, until `resume`, if the disk refuses it."""
        if self._failure is not None:
            raise self._failure
        name = channel.encode()
        header = HEADER.pack(SYNC, self.n_events, utime, len(name), len(data)) + name
        self._waiting += (header, data)
        self._waiting_bytes += len(header) + len(data)
        self.n_events += 1
        self.last_us = utime
        if (
            self._waiting_bytes >= _FLUSH_BYTES
            or len(self._waiting) >= 2 * _FLUSH_EVENTS
            or time.monotonic() - self._flushed_s >= _FLUSH_S
        ):
            self.flush()

    def flush(self) -> None:
        """Hand all events to the kernel; from then on they survive this process."""
        if self._failure is not None:
            raise self._failure
        waiting, self._waiting, self._waiting_bytes = self._waiting, [], 0
        self._flushed_s = time.monotonic()
        try:
            self._write_through(waiting)
        except OSError as error:
            self._failure = self._cut(waiting, error)
            raise self._failure from error

    def resume(self, room_bytes: int = 0) -> None:
        """Accept events again after a write error; raises LogError if the disk has not ``room_bytes`` for more."""
        if room_bytes:
            try:
                self._reserve(room_bytes)
            except OSError as error:
                raise self._cut([], error) from error
        self._failure = None
        self._waiting, self._waiting_bytes = [], 0

    def close(self) -> None:
        """Flush and close; idempotent."""
        if self._fd < 0:
            return
        try:
            if self._failure is None:
                self.flush()
        finally:
            os.close(self._fd)
            self._fd = -1

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _write_through(self, buffers: list[bytes]) -> None:
        if not buffers:
            return
        total = sum(map(len, buffers))
        written = write_some(self._fd, buffers)
        if written < total:
            rest = memoryview(b"".join(buffers))[written:]
            while rest:
                rest = rest[os.write(self._fd, rest) :]
        self._complete_bytes += total
        self._complete_us = self.last_us

    def _reserve(self, n_bytes: int) -> None:
        """Allocate this much behind the log, and give it back; raises OSError if the disk refuses it.

        Only Linux can allocate in this way; elsewhere the next write tells.
        """
        if not hasattr(os, "posix_fallocate"):
            return
        try:
            os.posix_fallocate(self._fd, self._complete_bytes, n_bytes)
        except OSError as error:
            if error.errno not in {errno.EOPNOTSUPP, errno.EINVAL}:  # a file system that cannot tell
                raise
        os.ftruncate(self._fd, self._complete_bytes)

    def _cut(self, buffers: list[bytes], error: OSError) -> LogError:
        """Cut the file after the last complete event and return the error message."""
        end, kept = self._complete_bytes, self.n_events - len(buffers) // 2
        last_us = self._complete_us
        size = os.fstat(self._fd).st_size
        for header, data in zip(buffers[::2], buffers[1::2], strict=True):
            if end + len(header) + len(data) > size:
                break
            end += len(header) + len(data)
            kept += 1
            last_us = HEADER.unpack_from(header)[2]
        self.n_events, self._complete_bytes = kept, end
        self.last_us = self._complete_us = last_us
        if size > end:
            os.ftruncate(self._fd, end)
            os.lseek(self._fd, end, os.SEEK_SET)
        return LogError(f"{self.path}: {error.strerror}; the log holds {kept} complete events")
