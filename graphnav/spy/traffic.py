"""What goes over each channel: type, rate, size, losses."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from graphnav.codec import DecodeError, codec_of, decode, fingerprint, lcm_name, type_named, type_of
from graphnav.errors import UserError, did_you_mean
from graphnav.messages import About
from graphnav.record import ABOUT
from graphnav.spy.adapted_types import load_adapted_types
from graphnav.spy.feed import Feed, Heard
from graphnav.spy.window import RECENT_S, Periods, Window

_SILENT_S = 1.0
_SILENT_PERIODS = 3
"""A channel is silent after so many of its periods without a message, and after a second at the earliest."""

Clock = Callable[[], float]


class Traffic:
    """All channels, by name, and the runs that said that they publish there.

    ``told`` says whether any run did; ``channels`` then holds what it promised, heard or not. ``clock`` returns the
    time now in seconds, on the clock of the arrivals; without one, as for a log, no channel is silent and rates are
    those of the newest 10,000 messages, else those of the last 10 s.
    """

    def __init__(self, clock: Clock | None = None) -> None:
        self._clock = clock
        self.channels: dict[str, ChannelTraffic] = {}
        self.runs: list[str] = []
        self.told = False
        load_adapted_types()

    def find(self, name: str, feed: Feed, for_s: float | None) -> ChannelTraffic:
        """Return a channel that was heard.

        Raises UserError where there is no such channel, GraphnavError where nothing came.
        """
        if name in self.channels and self.channels[name].count:
            return self.channels[name]
        if not self.channels:
            raise feed.silence(for_s)
        if name not in self.channels:
            raise self._unknown(name, feed)
        raise feed.silence(for_s, name)

    def check(self, name: str, feed: Feed) -> None:
        """Raise UserError where the runs that were heard have no such channel: waiting for it would be in vain."""
        if self.told and name not in self.channels:
            raise self._unknown(name, feed)

    def _unknown(self, name: str, feed: Feed) -> UserError:
        hint = did_you_mean(name, self.channels) or f"channels are {', '.join(sorted(self.channels))}"
        return UserError.of(f"{feed.name} has no channel '{name}'", hint)

    def hear(self, heard: Heard) -> ChannelTraffic:
        """Count a message; return its channel."""
        if heard.channel == ABOUT:
            self._learn(heard.data)
        channel = self.channels.get(heard.channel)
        if channel is None:
            channel = self.channels[heard.channel] = ChannelTraffic(heard.channel, clock=self._clock)
        channel.hear(heard)
        return channel

    def _learn(self, data: bytes) -> None:
        try:
            about = decode(About, data)[2]
        except DecodeError:
            return
        self.told = True
        for name, type_name in zip(about.channels, about.types, strict=False):
            channel = self.channels.setdefault(name, ChannelTraffic(name, type_name, self._clock))
            channel.type_name = channel.type_name or type_name
        if about.run_id and about.run_id not in self.runs:
            self.runs.append(about.run_id)


class ChannelTraffic:
    """The messages of one channel.

    ``values`` are the fields of the newest message that could be decoded; ``decodes`` says whether that is the newest.
    """

    def __init__(self, name: str, told: str | None = None, clock: Clock | None = None) -> None:
        self.name = name
        self.type_name = told
        self.lcm_class = type_named(told) if told else None
        self.count = self.undecodable = self.last_bytes = 0
        self.values: dict[str, Any] | None = None
        self.decodes = False
        self._clock = clock
        self._heard_s = 0.0
        self._recent_s = None if clock is None else RECENT_S
        self._arrivals, self._stamps = Window(self._recent_s), Window(self._recent_s)
        self._first_seq = self._last_seq = self._numbered = 0

    def hear(self, heard: Heard) -> None:
        """Count a message."""
        self.count += 1
        self.last_bytes = len(heard.data)
        self._heard_s = heard.at_s
        self._arrivals.add(heard.at_s, heard.at_s, self.count)
        values = self._decoded(heard.data)
        self.decodes = values is not None
        if values is None:
            self.undecodable += 1
            return
        self.values = values
        utime, seq = values.get("utime"), values.get("seq")
        if isinstance(utime, int) and isinstance(seq, int):
            if not self._numbered or seq <= self._last_seq:
                self._stamps, self._first_seq, self._numbered = Window(self._recent_s), seq, 0
            self._stamps.add(heard.at_s, utime / 1e6, seq)
            self._last_seq = seq
            self._numbered += 1

    @property
    def lost(self) -> int:
        """How many messages are missing between the first and the last since numbering began anew."""
        return max(0, self._last_seq - self._first_seq + 1 - self._numbered) if self._numbered else 0

    @property
    def silent_s(self) -> float | None:
        """How long ago the newest message arrived; None in a log and before the first."""
        return None if self._clock is None or not self.count else max(0.0, self._clock() - self._heard_s)

    @property
    def is_silent(self) -> bool:
        """Whether messages have stopped to come: none for 3 of its periods, and for a second at least."""
        silent_s, arriving = self.silent_s, self._arrivals.periods()
        period_s = 1 / arriving.rate_hz if arriving else 0.0
        return silent_s is not None and silent_s > max(_SILENT_S, _SILENT_PERIODS * period_s)

    @property
    def published(self) -> Periods | None:
        """Periods of the messages' own stamps, of the arrivals where a type has none; None of a silent channel."""
        if self.is_silent:
            return None
        return self._arrivals.periods() if self._stamps.is_empty else self._stamps.periods()

    @property
    def arriving(self) -> Periods | None:
        """Periods of the arrivals; None of a silent channel."""
        return None if self.is_silent else self._arrivals.periods()

    @property
    def rate_hz(self) -> float | None:
        """Messages published per second of their own stamps, the lost ones included."""
        return self.published.rate_hz if self.published else None

    @property
    def wall_rate_hz(self) -> float | None:
        """Messages per second as they arrived."""
        return self.arriving.rate_hz if self.arriving else None

    def _decoded(self, data: bytes) -> dict[str, Any] | None:
        if self.lcm_class is None or data[:8] != fingerprint(self.lcm_class):
            found = type_of(data)
            if found is None:
                return None
            self.lcm_class, self.type_name = found, lcm_name(found)
        try:
            return codec_of(self.lcm_class).decode(data)
        except DecodeError:
            return None
