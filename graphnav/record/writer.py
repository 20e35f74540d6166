"""Writing LCM logs that stay readable whatever happens."""

from __future__ import annotations

import os
import queue
import threading
import time
from pathlib import Path
from types import TracebackType
from typing import Self

from graphnav.errors import LogError
from graphnav.record.event import HEADER, SYNC

_FLUSH_BYTES = 1 << 18
_FLUSH_EVENTS = 400
"""Two buffers an event; the kernel takes 1024 at once."""
_FLUSH_S = 0.5
_MOST_BATCHES = 2
"""Once so many wait for a slow disk, the run waits too: a killed process loses 1 MB at most."""

Batch = list[bytes]


class LogWriter:
    """An LCM event log with the stamps that the events are given.

    Events gather until there are 256 kB or half a second of them; then a thread of its own hands them to the kernel in
    one call, so that a run does not wait for its log. If the disk refuses (it is full, or gone), the event that did not
    fit is cut away again, the next ``write`` or ``flush`` raises LogError, and the log up to there is whole.

    Raises OSError where the file cannot be opened at all.
    """

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        self.n_events = 0
        self._fd = os.open(self.path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o666)
        self._channels: dict[str, bytes] = {}
        self._waiting: Batch = []
        self._waiting_bytes = 0
        self._whole_bytes = 0
        self._whole_events = 0
        self._gathered_s = time.monotonic()
        self._failure: LogError | None = None
        self._told = False
        self._batches: queue.Queue[Batch | None] = queue.Queue(_MOST_BATCHES)
        self._thread: threading.Thread | None = None

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Append an event; raises LogError, once and for all, where the disk refused one."""
        name = self._channels.get(channel)
        if name is None:
            name = self._channels[channel] = channel.encode()
        header = HEADER.pack(SYNC, self.n_events, utime, len(name), len(data)) + name
        self._waiting += (header, data)
        self._waiting_bytes += len(header) + len(data)
        self.n_events += 1
        if (
            self._waiting_bytes >= _FLUSH_BYTES
            or len(self._waiting) >= 2 * _FLUSH_EVENTS
            or time.monotonic() - self._gathered_s >= _FLUSH_S
        ):
            self._hand_over()

    def flush(self) -> None:
        """Return once the kernel has all events; from then on they survive this process."""
        self._hand_over()
        self._batches.join()
        self._raise_failure()

    def close(self) -> None:
        """Flush and close; does nothing the second time."""
        if self._fd < 0:
            return
        try:
            if not self._told:
                self.flush()
        finally:
            if self._thread is not None:
                self._batches.put(None)
                self._thread.join()
            os.close(self._fd)
            self._fd = -1

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _hand_over(self) -> None:
        """Give what has gathered to the thread; raises what went wrong before."""
        self._raise_failure()
        if self._thread is None:
            self._thread = threading.Thread(target=self._write_batches, name="graphnav log", daemon=True)
            self._thread.start()
        batch, self._waiting, self._waiting_bytes = self._waiting, [], 0
        self._gathered_s = time.monotonic()
        self._batches.put(batch)

    def _raise_failure(self) -> None:
        if self._failure is not None:
            self.n_events, self._told = self._whole_events, True
            raise self._failure

    def _write_batches(self) -> None:
        """Write until told to stop; after a failure, drop what comes."""
        while (batch := self._batches.get()) is not None:
            if self._failure is None:
                try:
                    self._write_through(batch)
                except OSError as error:
                    self._failure = self._cut(batch, error)
            self._batches.task_done()

    def _write_through(self, buffers: list[bytes]) -> None:
        if not buffers:
            return
        total = sum(map(len, buffers))
        written = os.writev(self._fd, buffers)
        if written < total:
            rest = memoryview(b"".join(buffers))[written:]
            while rest:
                rest = rest[os.write(self._fd, rest) :]
        self._whole_bytes += total
        self._whole_events += len(buffers) // 2

    def _cut(self, buffers: list[bytes], error: OSError) -> LogError:
        """Cut the file behind the last whole event and return what is to be said."""
        end, kept = self._whole_bytes, self._whole_events
        size = os.fstat(self._fd).st_size
        for header, data in zip(buffers[::2], buffers[1::2], strict=True):
            if end + len(header) + len(data) > size:
                break
            end += len(header) + len(data)
            kept += 1
        self._whole_bytes, self._whole_events = end, kept
        if size > end:
            os.ftruncate(self._fd, end)
        return LogError(f"{self.path}: {error.strerror}; the log ends whole after {kept} events")
