"""Measure the traffic of each channel: type, rate, size, losses."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Any

from graphnav.core.catalog import Catalog
from graphnav.core.codec import DecodeError, codec_of, decode, lcm_name, type_named, type_of
from graphnav.core.errors import GraphnavError, Hint, UserError, did_you_mean, shown_name
from graphnav.core.messages import About
from graphnav.core.record import ABOUT
from graphnav.watch.spy.feed import Feed, Received, drops_of
from graphnav.watch.spy.message_window import RECENT_S, Periods, Sizes, Window
from graphnav.watch.spy.rate_history import RateHistory

_SILENT_S = 1.0
_SILENT_PERIODS = 3
"""A channel is silent after this number of its periods without a message, and after at least a second."""

MAX_CHANNELS = 512
"""Messages of further channels are only counted, to bound memory when a program sends random names."""
_MAX_EARLY_S, _MAX_LATE_S = 1.0, 60.0
"""A timestamp this far from wall time belongs to another clock."""
MAX_RUNS = 32
_MAX_NAMED = 12
"""Further channels are not named in an error."""
_MAX_GAP = 1_000_000
"""A larger step of the sequence numbers is a new numbering, not a loss."""
RUN_SILENT_S = 3.0
"""A run, which announces itself every second, has ended after this time without an announcement."""

Clock = Callable[[], float]


class Traffic:
    """All channels, by name, and the announced runs with the time of their last announcement.

    ``has_announcement``: whether a run was announced; ``channels`` then includes the announced ones. There are at most
    512 channels, and ``wanted``; ``overflow`` counts the messages of all others. ``count`` and ``undecodable`` include
    these messages. The newest 32 runs are kept; ``has_forgotten_runs``: whether there were more.
    ``clock`` returns the current time, seconds, on the arrival clock; with a clock rates are those of the last 10 s.
    Without a clock, as for a log, no channel is silent and rates are those of the newest 10,000 messages.
    """

    def __init__(self, clock: Clock | None = None, wanted: str | None = None) -> None:
        self._clock, self._wanted = clock, wanted
        self.channels: dict[str, ChannelTraffic] = {}
        self.runs: dict[str, float] = {}
        self.has_announcement = self.has_forgotten_runs = False
        self.overflow = self.count = self.undecodable = 0
        Catalog().load_types()

    def current_runs(self, now_s: float) -> list[str]:
        """Return the runs that still announce themselves, else the last ended one; in order of their start.

        ``now_s``: on the arrival clock.
        """
        current = [run_id for run_id, received_s in self.runs.items() if now_s - received_s < RUN_SILENT_S]
        return current or sorted(self.runs, key=self.runs.__getitem__)[-1:]

    def find(self, name: str, feed: Feed, for_s: float | None) -> ChannelTraffic:
        """Return a channel of which a message was received.

        Raises UserError if there is no such channel, GraphnavError if no message was received.
        """
        if name in self.channels and self.channels[name].count:
            return self.channels[name]
        if not self.channels:
            raise feed.silence(for_s)
        if name not in self.channels:
            raise self._unknown(name, feed)
        raise feed.silence(for_s, name)

    def silence(self, name: str, feed: Feed, for_s: float) -> GraphnavError:
        """Return the error that no message of a channel was received for some seconds, with what was received."""
        heard = [shown_name(other) for other, channel in sorted(self.channels.items()) if channel.count]
        if not heard:
            return feed.silence(for_s)
        more = f" and {len(heard) - _MAX_NAMED} more" if len(heard) > _MAX_NAMED else ""
        return GraphnavError(f"{feed.silence(for_s, name)}\n  received: {', '.join(heard[:_MAX_NAMED])}{more}")

    def ended_run(self, name: str, now_s: float) -> str | None:
        """Return the run that ended last, once every run has ended and the channel is silent; None before, or without.

        ``now_s``: on the arrival clock.
        """
        channel = self.channels.get(name)
        newest_s = max([*self.runs.values(), channel.received_s if channel is not None else 0.0], default=now_s)
        if not self.runs or now_s - newest_s < RUN_SILENT_S:
            return None
        return max(self.runs, key=self.runs.__getitem__)

    def check(self, name: str, feed: Feed) -> None:
        """Raise UserError if the announced runs have no such channel: waiting would be futile."""
        if self.has_announcement and name not in self.channels:
            raise self._unknown(name, feed)

    def _unknown(self, name: str, feed: Feed) -> UserError:
        name, names = shown_name(name), sorted(map(shown_name, self.channels))
        hint: Hint = did_you_mean(name, names) or f"channels are {', '.join(names)}"
        if dropped := drops_of(feed):
            hint = f"{hint}\n{dropped}, perhaps of this channel: run 'graphnav doctor'"
        return UserError.of(f"{feed.name} has no channel '{name}'", hint)

    def receive(self, received: Received) -> ChannelTraffic:
        """Count a message; return its channel, a temporary one beyond the maximum."""
        if received.channel == ABOUT:
            self._learn(received)
        channel = self._channel(received.channel)
        if channel is None:
            self.overflow += 1
            channel = ChannelTraffic(received.channel, clock=self._clock)
        channel.receive(received)
        self.count += 1
        self.undecodable += not channel.decodes
        return channel

    def _channel(self, name: str, announced_type: str | None = None) -> ChannelTraffic | None:
        """Return the channel of a name, created if new; None beyond the maximum."""
        channel = self.channels.get(name)
        if channel is None and (len(self.channels) < MAX_CHANNELS or name == self._wanted):
            channel = self.channels[name] = ChannelTraffic(name, announced_type, self._clock)
        return channel

    def _learn(self, received: Received) -> None:
        try:
            about = decode(About, received.data)[2]
        except DecodeError:
            return
        self.has_announcement = True
        for name, type_name in zip(about.channels[:MAX_CHANNELS], about.types, strict=False):
            channel = self._channel(name, type_name)
            if channel is not None:
                channel.type_name = channel.type_name or type_name
        if about.run_id:
            self.runs[about.run_id] = received.at_s
        if len(self.runs) > MAX_RUNS:
            self.has_forgotten_runs = True
            del self.runs[min(self.runs, key=self.runs.__getitem__)]


_STAMPED = 16
"""The bytes of a message's fingerprint and timestamp."""


class ChannelTraffic:
    """The messages of one channel.

    Every message is measured; only the newest one is decoded, on access to ``values``. ``decodes``: whether the newest
    message is complete and of a known type; ``is_unknown``: whether no installed type has its ``fingerprint``.
    ``received_s``: its time of arrival.
    """

    def __init__(self, name: str, announced_type: str | None = None, clock: Clock | None = None) -> None:
        self.name = name
        self.type_name = announced_type
        self.lcm_class = type_named(announced_type) if announced_type else None
        self.count = self.undecodable = self.last_bytes = 0
        self.decodes = self.is_unknown = False
        self.fingerprint = b""
        self.received_s = 0.0
        self.history = RateHistory()
        self._clock = clock
        self._newest: bytes | None = None
        self._values: dict[str, Any] | None = None
        self._recent_s = None if clock is None else RECENT_S
        self._arrivals, self._stamps = Window(self._recent_s), Window(self._recent_s)
        self._last_seq = self._last_utime = self._published = self._numbered = 0
        self._n_stops = 0

    def receive(self, received: Received) -> None:
        """Count a message."""
        data = received.data
        self.count += 1
        self.last_bytes = len(data)
        is_at_once = self._clock is None and received.at_s == self.received_s
        if is_at_once and self._newest is not None and data[:_STAMPED] == self._newest[:_STAMPED]:
            self._n_stops += 1  # it takes back the last command of a run, at the time of that
        self.received_s = received.at_s
        self._arrivals.add(received.at_s, received.at_s, self.count - self._n_stops, len(data))
        self.history.add(received.at_s)
        lcm_class = type_of(data)
        self.is_unknown, self.fingerprint = lcm_class is None, data[:8]
        codec = None if lcm_class is None else codec_of(lcm_class)
        self.decodes = codec is not None and codec.fits(data)
        if lcm_class is not None and (lcm_class is not self.lcm_class or self.type_name is None):
            self._take_type(lcm_class)
        if codec is None or not self.decodes:
            self.undecodable += 1
            return
        self._newest, self._values = data, None
        utime, seq = codec.peek(data, "utime"), codec.peek(data, "seq")
        if utime is not None and seq is not None:
            self._number(received, utime, seq)

    def _number(self, received: Received, utime: int, seq: int) -> None:
        """Count published messages, including lost ones; one by one if timestamps advance without sequence numbers."""
        step = seq - self._last_seq
        if step == 0 and utime > self._last_utime:
            step = 1
        if not self._numbered or not 0 < step <= _MAX_GAP:
            self._stamps, self._published, self._numbered, step = Window(self._recent_s), 0, 0, 1
        self._published += step
        self._numbered += 1
        self._last_seq, self._last_utime = seq, utime
        self._stamps.add(received.at_s, utime / 1e6, self._published - self._n_stops, len(received.data))

    def _take_type(self, lcm_class: type) -> None:
        """Set the type of the channel; forget messages of another type."""
        self.lcm_class, self.type_name = lcm_class, lcm_name(lcm_class)
        self._newest = self._values = None

    @property
    def values(self) -> dict[str, Any] | None:
        """The fields of the newest decodable message, None before the first."""
        if self._values is None and self._newest is not None and self.lcm_class is not None:
            with suppress(DecodeError):  # sizes beyond what numpy can shape
                self._values = codec_of(self.lcm_class).decode(self._newest)
        return self._values

    def latency_s(self, clock_offset_s: float) -> float | None:
        """Return the median time from a message's timestamp to its arrival.

        ``clock_offset_s`` is added to the arrival clock to give wall time. None if the timestamps are not wall time.
        """
        behind_s = self._stamps.behind_s()
        if behind_s is None:
            return None
        latency_s = behind_s + clock_offset_s
        return latency_s if latency_s and -_MAX_EARLY_S < latency_s < _MAX_LATE_S else None

    @property
    def lost(self) -> int:
        """The number of missing messages between the first and the last since the numbering restarted."""
        return self._published - self._numbered

    @property
    def silent_s(self) -> float | None:
        """The time since the newest message arrived; None for a log and before the first message."""
        return None if self._clock is None or not self.count else max(0.0, self._clock() - self.received_s)

    @property
    def is_silent(self) -> bool:
        """Whether messages have stopped: none for 3 periods, and for at least a second."""
        silent_s, rate_hz = self.silent_s, self._arrivals.rate_hz()
        period_s = 1 / rate_hz if rate_hz else 0.0
        return silent_s is not None and silent_s > max(_SILENT_S, _SILENT_PERIODS * period_s)

    @property
    def published(self) -> Periods | None:
        """Periods of the messages' timestamps, of the arrivals if a type has none; None for a silent channel."""
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
        """Messages per second by timestamp, including lost ones."""
        return self.published.rate_hz if self.published else None

    @property
    def wall_rate_hz(self) -> float | None:
        """Messages per second by arrival."""
        return self.arriving.rate_hz if self.arriving else None
