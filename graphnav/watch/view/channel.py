"""The statistics of one channel, counted without decoding, with bounded memory."""

from __future__ import annotations

from collections import deque
from statistics import median

from graphnav.watch.spy import Periods, Received
from graphnav.watch.spy.message_window import RECENT_S, Window
from graphnav.watch.view.message_types import Kind

_SILENT_S = 1.0
_SILENT_PERIODS = 3
_MAX_GAP = 1_000_000
"""A larger step of the sequence numbers is a new numbering, not a loss."""
_N_LATENCIES = 32
SMALL_BYTES = 1024
"""Messages up to this size are stored for plots."""
_MAX_HISTORY = 600
_MAX_HISTORY_BYTES = 65_536


class WatchedChannel:
    """The messages of one channel.

    ``count`` numbers the messages from 1. ``newest``: the newest message, unless it is too large; ``history``: the
    newest small messages with their numbers. ``lost``: missing sequence numbers since the numbering started.
    ``undecodable``: messages of an unknown type, too short for their type, or not decodable. ``is_single``: whether all
    messages have the same sequence number and timestamp: published once, and possibly repeated for late subscribers.
    """

    def __init__(self, name: str, type_name: str = "") -> None:
        self.name, self.type_name = name, type_name
        self.kind: Kind | None = None
        self.count = self.lost = self.undecodable = self.last_bytes = 0
        self.newest: Received | None = None
        self.is_too_large = False
        self.is_single = True
        self.history: deque[tuple[int, Received]] = deque()
        self.received_s = 0.0
        self._history_bytes = 0
        self._window = Window(RECENT_S)
        self._noted = self._published = 0
        self._last_seq: int | None = None
        self._last_utime: int | None = None
        self._latencies_s: deque[float] = deque(maxlen=_N_LATENCIES)

    def receive(self, received: Received, kind: Kind | None) -> int | None:
        """Count a message; return its timestamp if it differs from that of the previous message."""
        self.count += 1
        self.last_bytes = len(received.data)
        self.received_s = received.at_s
        if kind is None or len(received.data) < kind.min_bytes:
            self.undecodable += 1
            self._window.add(received.at_s, received.at_s, self.count)
            return None
        if kind is not self.kind:
            self.kind, self.type_name = kind, kind.name
            self._restart()
        if len(received.data) <= SMALL_BYTES:
            self._keep(received)
        stamped = kind.stamp(received.data)
        if stamped is None:
            self._window.add(received.at_s, received.at_s, self.count)
            return None
        utime, is_new = stamped[0], stamped[0] != self._last_utime
        self._number(received.at_s, *stamped)
        return utime if is_new else None

    def note_undecodable(self, number: int) -> None:
        """Count an undecodable message, once."""
        if number != self._noted:
            self._noted = number
            self.undecodable += 1

    def add_latency(self, latency_s: float) -> None:
        """Add the delay of a message after the first message of its timestamp."""
        self._latencies_s.append(latency_s)

    @property
    def latency_s(self) -> float | None:
        """The median of the newest latencies; None if all messages are the first of their timestamps."""
        is_known = not self.is_single and max(self._latencies_s, default=0.0) > 0
        return median(self._latencies_s) if is_known else None

    def periods(self, now_s: float) -> Periods | None:
        """Return the periods of the newest 10 s; None for a silent channel."""
        periods = self._window.periods()
        if periods is None:
            return None
        quiet_s = max(_SILENT_S, _SILENT_PERIODS / periods.rate_hz if periods.rate_hz > 0 else _SILENT_S)
        return None if now_s - self.received_s > quiet_s else periods

    def _number(self, at_s: float, utime: int, seq: int) -> None:
        gap = 1 if self._last_seq is None else seq - self._last_seq
        self.is_single &= self._last_seq is None or (seq, utime) == (self._last_seq, self._last_utime)
        if gap == 0 and self._last_utime is not None and utime > self._last_utime:
            gap = 1  # the sender does not number its messages
        if 0 < gap <= _MAX_GAP:
            self.lost += gap - 1
        else:
            self._window = Window(RECENT_S)
            self.lost, gap = self.lost if gap == 0 else 0, 1
        self._last_seq, self._last_utime = seq, utime
        self._published += gap
        self._window.add(at_s, utime / 1e6, self._published)

    def _restart(self) -> None:
        self._last_seq = None
        self._window = Window(RECENT_S)
        self._latencies_s.clear()
        self.history.clear()
        self._history_bytes = 0

    def _keep(self, received: Received) -> None:
        self.history.append((self.count, received))
        self._history_bytes += len(received.data)
        while len(self.history) > _MAX_HISTORY or self._history_bytes > _MAX_HISTORY_BYTES:
            self._history_bytes -= len(self.history.popleft()[1].data)
