"""Write a log in a separate thread: a slow or full disk never blocks the caller."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple, Protocol

from graphnav.core.codec import encode
from graphnav.core.errors import LogError
from graphnav.core.messages import Gap
from graphnav.core.record.writer import LogWriter

_MAX_QUEUED_BYTES = 64 << 20
_EVENT_BYTES = 200
"""Approximate memory overhead of a queued event."""
_IDLE_S = 0.5
_GATHER_S = 0.01
"""Events within this time wake the thread once, which saves context switches."""
_RETRY_S, _MAX_RETRY_S = 1.0, 8.0
"""After a write error the disk is tried again this often; less often each time that it refuses within `_STEADY_S`."""
_STEADY_S = 5.0
_ROOM_BYTES = 1 << 20
"""The recording goes on when the disk has room for this much: a few free bytes would end it at once again."""
_CLOSE_S = 5.0


class Log(Protocol):
    """The log that the thread writes; ``n_events`` and ``n_bytes`` include unflushed events."""

    @property
    def n_events(self) -> int:
        """The number of events."""

    @property
    def n_bytes(self) -> int:
        """Their size."""

    @property
    def last_us(self) -> int | None:
        """The timestamp of the last event, None without one."""

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Append an event; raises LogError if the disk refuses it."""

    def flush(self) -> None:
        """Hand all events to the kernel; called periodically while the queue is empty."""

    def resume(self, room_bytes: int = 0) -> None:
        """Accept events again after an error; raises LogError if the disk has not ``room_bytes`` for more."""

    def close(self) -> None:
        """Flush and close."""


class LogGap(NamedTuple):
    """Messages that are missing in a log: their number, and the timestamps of the events around them, microseconds."""

    from_us: int
    until_us: int
    n_messages: int


class _Pause(NamedTuple):
    """Why events are dropped at present, and the timestamp of the last event in the log, or else of the first lost.

    ``failure`` names the log, ``reason`` is what the system says.
    """

    failure: str
    reason: str
    from_us: int


class ThreadedLogWriter:
    """A log behind a bounded queue.

    An event that does not fit into the queue of ``max_bytes`` is dropped and counted. If the disk refuses an event (it
    is full), events are dropped and counted, and the disk is tried again once a second; once it has room, a `Gap`
    says what is missing, and the recording goes on. Any other error ends the recording, and so does a disk that still
    refuses when the log is closed: ``failure`` says so. The log up to an error is complete. ``notice`` is called
    from another thread when events begin to be missing, when they are recorded again, and when the recording ends.
    ``open_log`` opens the log.

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
        self.failure = ""
        """Why the recording ended early, empty if it did not."""
        self.gaps: list[LogGap] = []
        """Gaps that the log tells: the disk refused these messages."""
        self._log = open_log(self.path)
        self._max_bytes, self._notice = max_bytes, notice
        self._offered = self._refused = self._taken = 0
        """Events that were given, those that were not queued, and those that the thread took from the queue."""
        self._lost = self._told = 0
        """Of those taken, the ones that are not in the log, and the ones that ``gaps`` tell."""
        self._first_us = self._last_us = 0
        """The timestamps of the first and of the last event that the thread took."""
        self._pause: _Pause | None = None
        self._wait_s, self._retry_s, self._resumed_s = _RETRY_S, 0.0, -math.inf
        self._queued_bytes = 0
        self._queue: deque[tuple[str, int, bytes]] = deque()
        self._is_closing = self._is_waiting = False
        self._closing = threading.Event()
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._work, name="graphnav log", daemon=True)
        self._thread.start()

    @property
    def dropped(self) -> int:
        """The number of events that are not in the log."""
        return self._refused + self._lost

    @property
    def fault(self) -> str:
        """Why events are not recorded at present, empty if they are."""
        pause = self._pause
        return self.failure or ("" if pause is None else pause.reason)

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
                self._refused += 1
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
                if self._pause is not None and not self._resumes(self._last_us):
                    self._fail(self._pause.failure)
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
        """Write events, or flush if there are none; drop them while the disk refuses them."""
        n_done = 0
        if events:
            self._first_us, self._last_us = self._first_us if self._taken else events[0][1], events[-1][1]
        try:
            if not events and self._pause is None:
                self._log.flush()
            if events and (self._pause is None or self._resumes(events[0][1])):
                for channel, utime, data in events:
                    if self.failure:
                        return
                    self._log.write(channel, utime, data)
                    n_done += 1
                    with self._changed:
                        self._queued_bytes -= len(data) + _EVENT_BYTES
        except (LogError, OSError) as error:
            cause = error if isinstance(error, OSError) else error.__cause__
            if not isinstance(cause, OSError):
                raise
            reason = cause.strerror or str(cause)
            self._begin_pause(str(error), reason)
        rest = events[n_done:]
        with self._changed:
            self._taken += len(events)
            self._queued_bytes -= sum(len(data) + _EVENT_BYTES for _, _, data in rest)
            self._lost = self._taken - (self._log.n_events - len(self.gaps))

    def _begin_pause(self, failure: str, reason: str) -> None:
        """Begin to drop events."""
        now_s = time.monotonic()
        is_again = now_s - self._resumed_s < _STEADY_S
        self._wait_s = min(2 * self._wait_s, _MAX_RETRY_S) if is_again else _RETRY_S
        self._retry_s = now_s + self._wait_s
        last_us = self._log.last_us
        self._pause = _Pause(failure, reason, self._first_us if last_us is None else last_us)
        self._notice(f"{failure}; messages are dropped until the disk takes them")

    def _resumes(self, utime: int) -> bool:
        """Whether the disk takes events again, from one with this timestamp on; the log then tells what is missing."""
        pause, now_s = self._pause, time.monotonic()
        if pause is None or (now_s < self._retry_s and not self._is_closing):
            return False
        self._retry_s = now_s + self._wait_s
        gap = LogGap(pause.from_us, utime, self._lost - self._told)
        try:
            self._log.resume(0 if self._is_closing else _ROOM_BYTES)
            told = Gap(from_us=gap.from_us, n_messages=gap.n_messages, reason=pause.reason)
            self._log.write(Gap.CHANNEL, utime, encode(told, utime, len(self.gaps)))
            self._log.flush()
        except (LogError, OSError):
            return False
        self.gaps.append(gap)
        self._told, self._pause, self._resumed_s = self._lost, None, now_s
        span_s = (gap.until_us - gap.from_us) / 1e6
        self._notice(f"{self.path}: recording again; {gap.n_messages} messages of {span_s:.1f} s are missing")
        return True

    def _fail(self, failure: str) -> None:
        """End the recording, once."""
        with self._changed:
            if self.failure:
                return
            self.failure = failure
            self._queue.clear()
            self._queued_bytes = 0
            self._lost = self._offered - self._refused - (self._log.n_events - len(self.gaps))
        self._notice(failure)
