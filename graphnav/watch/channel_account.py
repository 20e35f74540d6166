"""The account of one channel: messages, sizes, rate, losses, delays and silence, in bounded memory."""

from __future__ import annotations

import struct
from collections import OrderedDict, deque
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from statistics import median

from graphnav.core.codec import Codec, codec_of, fields_of, lcm_name, type_named, type_of
from graphnav.core.record import RECENT_S, Periods, Sizes, Window, silent_after_s
from graphnav.watch.sequence_gaps import SequenceGaps

_FINGERPRINT_BYTES = 8
_STAMPED_BYTES = 24
"""The bytes of a fingerprint, a stamp and a sequence number."""
_STAMP = struct.Struct(">qq")
_MAX_KINDS = 1024
_MAX_EARLY_S, _MAX_LATE_S = 1.0, 60.0
"""A stamp this far from wall time belongs to another clock."""
_N_PIPELINE_DELAYS = 32
_MAX_STAMPS = 256

Clock = Callable[[], float]


@dataclass(frozen=True)
class Kind:
    """A known type; ``is_stamped``: whether its messages begin with ``utime`` and ``seq``."""

    lcm_class: type
    name: str
    codec: Codec
    is_stamped: bool

    @property
    def min_bytes(self) -> int:
        """The size of the shortest complete message."""
        return _FINGERPRINT_BYTES + self.codec.min_bytes

    def stamp(self, data: bytes) -> tuple[int, int] | None:
        """Return the stamp (microseconds) and the sequence number of a message, None without them."""
        if self.is_stamped:
            return _STAMP.unpack_from(data, _FINGERPRINT_BYTES) if len(data) >= _STAMPED_BYTES else None
        if not self.codec.fits(data):
            return None
        utime, seq = self.codec.peek(data, "utime"), self.codec.peek(data, "seq")
        return None if utime is None or seq is None else (utime, seq)


def kind_of(data: bytes) -> Kind | None:
    """Return the type of a message by its fingerprint, None if it is not installed."""
    lcm_class = type_of(data)
    return None if lcm_class is None else _kind(lcm_class)


@lru_cache(_MAX_KINDS)
def _kind(lcm_class: type) -> Kind:
    first = [(field.name, field.primitive, field.dims) for field in fields_of(lcm_class)[:2]]
    is_stamped = first == [("utime", "int64_t", ()), ("seq", "int64_t", ())]
    return Kind(lcm_class, lcm_name(lcm_class), codec_of(lcm_class), is_stamped)


class ChannelCounts:
    """How many messages of which sizes, when, and what is missing, without a look at their content.

    ``first_s``, ``received_s``: arrivals of the first and the newest message. ``gaps``: by sequence numbers, which the
    owner hands to it.
    """

    __slots__ = ("count", "first_s", "gaps", "last_bytes", "max_bytes", "min_bytes", "n_bytes", "received_s")

    def __init__(self) -> None:
        self.count = self.n_bytes = self.last_bytes = self.min_bytes = self.max_bytes = 0
        self.first_s = self.received_s = 0.0
        self.gaps = SequenceGaps()

    def add(self, n_bytes: int, at_s: float) -> None:
        """Count a message."""
        if not self.count:
            self.first_s, self.min_bytes = at_s, n_bytes
        self.count += 1
        self.n_bytes += n_bytes
        self.last_bytes, self.received_s = n_bytes, at_s
        self.min_bytes, self.max_bytes = min(self.min_bytes, n_bytes), max(self.max_bytes, n_bytes)

    @property
    def rate_hz(self) -> float | None:
        """Messages per second between the first and the last arrival; None for a zero duration."""
        length_us = round((self.received_s - self.first_s) * 1e6)
        return (self.count - 1) / length_us * 1e6 if length_us else None


class ChannelAccount:
    """The messages of one channel, which are measured and not decoded.

    ``counts``: of all messages. ``kind``, ``type_name``: of the newest message of a known type, or as announced.
    ``undecodable``: messages of an unknown type, or incomplete ones; ``decodes``: whether the newest is none of them;
    ``is_unknown``: whether no installed type has its ``fingerprint``. ``is_single``: whether all messages have the same
    sequence number and stamp: published once, and possibly repeated for late subscribers.

    ``clock`` returns the current time, seconds, on the arrival clock; with a clock rates are those of the last 10 s.
    Without a clock, as for a log, the channel is never silent and rates are those of the newest 10,000 messages.

    There are two delays. The *transport age* is the arrival of a message minus its stamp. The *pipeline delay* is its
    arrival after that of the first message of the same stamp on any channel.
    """

    def __init__(self, name: str, announced_type: str | None = None, clock: Clock | None = None) -> None:
        self.name, self.type_name = name, announced_type
        lcm_class = type_named(announced_type) if announced_type else None
        self.kind = None if lcm_class is None else _kind(lcm_class)
        self.counts = ChannelCounts()
        self.undecodable = 0
        self.decodes = self.is_unknown = False
        self.is_single = True
        self.fingerprint = b""
        self._clock = clock
        self._recent_s = None if clock is None else RECENT_S
        self._arrivals, self._stamps = Window(self._recent_s), Window(self._recent_s)
        self._stamp: tuple[int, int] | None = None
        self._head = b""
        self._number = self._n_stops = 0
        self._pipeline_s: deque[float] = deque(maxlen=_N_PIPELINE_DELAYS)

    def receive(self, data: bytes, at_s: float) -> int | None:
        """Count a message that arrived at ``at_s``; return its stamp if it differs from that of the previous one."""
        self._note_stop(data, at_s)
        self.counts.add(len(data), at_s)
        self._arrivals.add(at_s, at_s, self.counts.count - self._n_stops, len(data))
        kind = kind_of(data)
        self.is_unknown, self.fingerprint = kind is None, data[:_FINGERPRINT_BYTES]
        self.decodes = kind is not None and kind.codec.fits(data)
        if kind is not None and (kind is not self.kind or self.type_name is None):
            self.change_type(kind)
        if kind is None or not self.decodes:
            self.undecodable += 1
            return None
        self._head = data[:16]
        stamp, before = kind.stamp(data), self._stamp
        if stamp is None:
            return None
        self._add_stamp(stamp, at_s, len(data))
        return stamp[0] if before is None or stamp[0] != before[0] else None

    def change_type(self, kind: Kind) -> None:
        """Take the type of a message as that of the channel; numbers and delays of another type are forgotten."""
        self.kind, self.type_name = kind, kind.name
        self._stamp, self._stamps = None, Window(self._recent_s)
        self._pipeline_s.clear()

    def add_pipeline_delay(self, delay_s: float) -> None:
        """Add the delay of a message after the first message of its stamp."""
        self._pipeline_s.append(delay_s)

    def _note_stop(self, data: bytes, at_s: float) -> None:
        """Leave out of the rate what takes back the last command of a run, in a log at the time of that."""
        is_at_once = self._clock is None and self.counts.count > 0 and at_s == self.counts.received_s
        self._n_stops += is_at_once and bool(self._head) and data[:16] == self._head

    def _add_stamp(self, stamp: tuple[int, int], at_s: float, n_bytes: int) -> None:
        """Count published messages, including lost ones; one by one if stamps advance without sequence numbers."""
        before, gaps = self._stamp, self.counts.gaps
        n_lost, n_restarts = gaps.lost, gaps.n_restarts
        gaps.see(stamp[1])
        if before is None or gaps.n_restarts != n_restarts or stamp == before:
            self._stamps = Window(self._recent_s)
        self.is_single &= before is None or stamp == before
        self._stamp = stamp
        self._number += 1 + gaps.lost - n_lost
        self._stamps.add(at_s, stamp[0] / 1e6, self._number - self._n_stops, n_bytes)

    @property
    def count(self) -> int:
        """The number of messages."""
        return self.counts.count

    @property
    def last_bytes(self) -> int:
        """The size of the newest message."""
        return self.counts.last_bytes

    @property
    def received_s(self) -> float:
        """The arrival of the newest message, 0 before the first."""
        return self.counts.received_s

    @property
    def lcm_class(self) -> type | None:
        """The lcm-gen class of the channel's type, None if it is not known."""
        return None if self.kind is None else self.kind.lcm_class

    @property
    def lost(self) -> int:
        """The number of missing messages, by sequence numbers."""
        return self.counts.gaps.lost

    @property
    def lost_since_restart(self) -> int:
        """The number of missing messages since a sender restarted its numbers."""
        return self.counts.gaps.lost_since_restart

    def transport_age_s(self, clock_offset_s: float) -> float | None:
        """Return the median time from a message's stamp to its arrival, over the newest 100.

        ``clock_offset_s`` is added to the arrival clock to give wall time. None if the stamps are not wall time.
        """
        behind_s = self._stamps.behind_s()
        if behind_s is None:
            return None
        age_s = behind_s + clock_offset_s
        return age_s if age_s and -_MAX_EARLY_S < age_s < _MAX_LATE_S else None

    @property
    def pipeline_delay_s(self) -> float | None:
        """The median of the newest 32 pipeline delays; None if all messages are the first of their stamps."""
        is_known = not self.is_single and max(self._pipeline_s, default=0.0) > 0
        return median(self._pipeline_s) if is_known else None

    @property
    def silent_s(self) -> float | None:
        """The time since the newest message arrived; None for a log and before the first message."""
        return None if self._clock is None or not self.count else max(0.0, self._clock() - self.received_s)

    @property
    def is_silent(self) -> bool:
        """Whether messages have stopped: none for 3 periods, and for at least a second."""
        silent_s = self.silent_s
        return silent_s is not None and silent_s > silent_after_s(self._arrivals.period_s)

    @property
    def published(self) -> Periods | None:
        """Periods of the messages' stamps, of the arrivals if a type has none; None for a silent channel."""
        if self.is_silent:
            return None
        return self._arrivals.periods() if self._stamps.is_empty else self._stamps.periods()

    @property
    def arriving(self) -> Periods | None:
        """Periods of the arrivals; None for a silent channel."""
        return None if self.is_silent else self._arrivals.periods()

    @property
    def sizes(self) -> Sizes:
        """Sizes of the messages in the rate window; raises ValueError before the first message."""
        return self._arrivals.sizes()

    @property
    def bytes_per_s(self) -> float | None:
        """Bytes per second by arrival; None for fewer than two messages and for a silent channel."""
        return None if self.is_silent else self._arrivals.bytes_per_s()

    @property
    def rate_hz(self) -> float | None:
        """Messages per second by stamp, including lost ones."""
        return self.published.rate_hz if self.published else None

    @property
    def wall_rate_hz(self) -> float | None:
        """Messages per second by arrival."""
        return self.arriving.rate_hz if self.arriving else None


class FirstArrivals:
    """When the first message of each of the newest 256 stamps arrived, on any channel."""

    def __init__(self) -> None:
        self._first_s: OrderedDict[int, float] = OrderedDict()

    def delay_s(self, utime: int, at_s: float) -> float:
        """Return the pipeline delay of a message: its arrival after the first message of its stamp."""
        first_s = self._first_s.setdefault(utime, at_s)
        if len(self._first_s) > _MAX_STAMPS:
            self._first_s.popitem(last=False)
        return max(0.0, at_s - first_s)
