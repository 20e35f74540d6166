"""What goes over each channel: type, rate, size, losses."""

from __future__ import annotations

from typing import Any

from graphnav.codec import DecodeError, codec_of, decode, fingerprint, lcm_name, type_named, type_of
from graphnav.errors import UserError, did_you_mean
from graphnav.messages import About
from graphnav.record import ABOUT
from graphnav.spy.adapted_types import load_adapted_types
from graphnav.spy.feed import Feed, Heard


class Traffic:
    """All channels, by name, and the runs that said that they publish there.

    ``told`` says whether any run did; ``channels`` then holds what it promised, heard or not.
    """

    def __init__(self) -> None:
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
            channel = self.channels[heard.channel] = ChannelTraffic(heard.channel)
        channel.hear(heard)
        return channel

    def _learn(self, data: bytes) -> None:
        try:
            about = decode(About, data)[2]
        except DecodeError:
            return
        self.told = True
        for name, type_name in zip(about.channels, about.types, strict=False):
            channel = self.channels.setdefault(name, ChannelTraffic(name, type_name))
            channel.type_name = channel.type_name or type_name
        if about.run_id and about.run_id not in self.runs:
            self.runs.append(about.run_id)


class ChannelTraffic:
    """The messages of one channel.

    ``values`` are the fields of the newest message that could be decoded; ``decodes`` says whether that is the newest.
    """

    def __init__(self, name: str, told: str | None = None) -> None:
        self.name = name
        self.type_name = told
        self.lcm_class = type_named(told) if told else None
        self.count = self.undecodable = self.last_bytes = 0
        self.values: dict[str, Any] | None = None
        self.decodes = False
        self._stamps = Span()
        self._arrivals = Span()
        self._seqs = Span()

    def hear(self, heard: Heard) -> None:
        """Count a message."""
        self.count += 1
        self.last_bytes = len(heard.data)
        self._arrivals.add(heard.at_s)
        values = self._decoded(heard.data)
        self.decodes = values is not None
        if values is None:
            self.undecodable += 1
            return
        self.values = values
        utime, seq = values.get("utime"), values.get("seq")
        if isinstance(utime, int) and isinstance(seq, int):
            if self._seqs.last is not None and seq <= self._seqs.last:
                self._stamps, self._seqs = Span(), Span()
            self._stamps.add(utime / 1e6)
            self._seqs.add(seq)

    @property
    def lost(self) -> int:
        """How many messages are missing between the first and the last since numbering began anew."""
        return max(0, round(self._seqs.length) + 1 - self._seqs.count) if self._seqs.count else 0

    @property
    def rate_hz(self) -> float | None:
        """Messages published per second of their own stamps, the lost ones included."""
        return self._stamps.rate(self._seqs.length) if self._stamps.count else self._arrivals.rate()

    @property
    def wall_rate_hz(self) -> float | None:
        """Messages per second as they arrived."""
        return self._arrivals.rate()

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


class Span:
    """From the first to the last of some growing numbers."""

    def __init__(self) -> None:
        self.count = 0
        self.first = 0.0
        self.last: float | None = None

    def add(self, value: float) -> None:
        """Take the next number."""
        if not self.count:
            self.first = value
        self.last = value
        self.count += 1

    @property
    def length(self) -> float:
        """The last less the first, 0 without any."""
        return 0.0 if self.last is None else self.last - self.first

    def rate(self, steps: float | None = None) -> float | None:
        """Return steps per unit, by default one less than there are numbers; None where there is no length."""
        steps = self.count - 1 if steps is None else steps
        return steps / self.length if self.length > 0 else None
