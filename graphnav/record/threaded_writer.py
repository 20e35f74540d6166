"""Write a log in a separate thread: a slow or full disk never blocks the caller."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

from graphnav.errors import LogError
from graphnav.record.writer import LogWriter

_MAX_QUEUED_BYTES = 64 << 20
_EVENT_BYTES = 200
"""Approximate memory overhead of a queued event."""
_IDLE_S = 0.5
_GATHER_S = 0.01
"""Events within this time wake the thread once, which saves context switches."""
_CLOSE_S = 5.0


class Log(Protocol):
    """The log that the thread writes; ``n_events`` and ``n_bytes`` include unflushed events."""

    @property
    def n_events(self) -> int:
        """The number of events."""

    @property
    def n_bytes(self) -> int:
        """Their size."""

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Append an event; raises LogError if the disk refuses it."""

    def flush(self) -> None:
        """Hand all events to the kernel; called periodically while the queue is empty."""

    def close(self) -> None:
        """Flush and close."""


class ThreadedLogWriter:
    """A log behind a bounded queue.

    An event that does not fit into the queue of ``max_bytes`` is dropped and counted. A write error ends the recording:
    ``failure`` is set, ``notice`` is called once with it from another thread, and every later event is dropped; the log
    up to the error is complete. ``open_log`` opens the log.

    Raises OSError if the file cannot be opened at all.
    """

    def __init__(
        self,
        path: Path | str,
        max_bytes: int = _MAX_QUEUED_BYTES,
        notice: Callable[[str], None] = lambda _: None,
        open_log: Callable[[Path], Log] = LogWriter,
    ) -> None:
        self.path = Path(path)
        self.dropped = 0
        """The number of events that are not in the log."""
        self.failure = ""
        """Why the recording ended early, empty if it did not."""
        self._log = open_log(self.path)
        self._max_bytes, self._notice = max_bytes, notice
        self._offered = 0
        self._queued_bytes = 0
        self._queue: deque[tuple[str, int, bytes]] = deque()
        self._is_closing = self._is_waiting = False
        self._closing = threading.Event()
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._work, name="graphnav log", daemon=True)
        self._thread.start()

    @property
    def n_events(self) -> int:
        """The number of events in the log, including unflushed ones."""
        return self._log.n_events

    @property
    def n_bytes(self) -> int:
        """The size of the log, including unflushed events."""
        return self._log.n_bytes

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Queue an event, or drop it; returns at once and never raises."""
        size = len(data) + _EVENT_BYTES
        with self._changed:
            self._offered += 1
            if self.failure or self._is_closing or self._queued_bytes + size > self._max_bytes:
                self.dropped += 1
                return
            self._queue.append((channel, utime, data))
            self._queued_bytes += size
            if self._is_waiting:
                self._is_waiting = False
                self._changed.notify()

    def close(self, timeout_s: float = _CLOSE_S) -> None:
        """Write the queued events and close; after ``timeout_s`` the remaining events are dropped and counted."""
        with self._changed:
            self._is_closing = True
            self._closing.set()
            self._changed.notify()
        self._thread.join(timeout_s)
        if self._thread.is_alive():
            self._fail(f"{self.path}: the last events were not written within {timeout_s:g} s")

    def _work(self) -> None:
        try:
            try:
                while (events := self._next()) is not None:
                    self._write_all(events)
            finally:
                self._log.close()
        except (LogError, OSError) as error:
            self._fail(str(error))

    def _next(self) -> list[tuple[str, int, bytes]] | None:
        """Wait for events and return them all; none after a timeout, None when the log is closing."""
        with self._changed:
            if not self._queue and not self._is_closing:
                self._is_waiting = True
                self._changed.wait(_IDLE_S)
                self._is_waiting = False
            if not self._queue and self._is_closing:
                return None
        self._closing.wait(_GATHER_S)
        with self._changed:
            events = list(self._queue)
            self._queue.clear()
        return events

    def _write_all(self, events: list[tuple[str, int, bytes]]) -> None:
        """Write events, or flush if there are none."""
        if not events:
            self._log.flush()
        for channel, utime, data in events:
            if self.failure:
                return
            self._log.write(channel, utime, data)
            with self._changed:
                self._queued_bytes -= len(data) + _EVENT_BYTES

    def _fail(self, failure: str) -> None:
        """End the recording, once."""
        with self._changed:
            if self.failure:
                return
            self.failure = failure
            self._queue.clear()
            self._queued_bytes = 0
            self.dropped = self._offered - self.n_events
        self._notice(failure)
