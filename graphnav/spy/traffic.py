"""What goes over each channel: type, rate, size, losses."""

from __future__ import annotations

import difflib
from typing import Any

from graphnav.codec import DecodeError, codec_of, decode, type_named, type_of
from graphnav.errors import UserError
from graphnav.messages import About
from graphnav.record import ABOUT
from graphnav.spy.source import Heard, Source


class Traffic:
    """All channels, by name, and the runs that said that they publish there."""

    def __init__(self) -> None:
        self.channels: dict[str, ChannelTraffic] = {}
        self.runs: list[str] = []
        self._told: dict[str, str] = {}

    def find(self, name: str, source: Source, for_s: float | None) -> ChannelTraffic:
        """Return a channel that was heard, else raise what a user must know: UserError if there are others."""
        if name in self.channels:
            return self.channels[name]
        if not self.channels:
            raise source.silence(for_s)
        raise self._unknown(name, source, sorted(self.channels))

    def check(self, name: str, source: Source) -> None:
        """Raise UserError where the runs that were heard have no such channel; waiting for it would be in vain."""
        if self._told and name not in self._told and name not in self.channels:
            raise self._unknown(name, source, sorted({*self._told, *self.channels}))

    def _unknown(self, name: str, source: Source, names: list[str]) -> UserError:
        close = difflib.get_close_matches(name, names, 1)
        hint = f"did you mean '{close[0]}'?" if close else f"channels are {', '.join(names)}"
        return UserError.of(f"{source.name} has no channel '{name}'", hint)

    def hear(self, heard: Heard) -> ChannelTraffic:
        """Count a message; return its channel."""
        if heard.channel == ABOUT:
            self._learn(heard.data)
        channel = self.channels.get(heard.channel)
        if channel is None:
            channel = self.channels[heard.channel] = ChannelTraffic(heard.channel)
        channel.hear(heard, self._told.get(heard.channel))
        return channel

    def _learn(self, data: bytes) -> None:
        try:
            about = decode(About, data)[2]
        except DecodeError:
            return
        self._told |= dict(zip(about.channels, about.types, strict=False))
        if about.run_id and about.run_id not in self.runs:
            self.runs.append(about.run_id)


class ChannelTraffic:
    """The messages of one channel.

    ``values`` are the fields of the newest message that could be decoded; ``decodes`` says whether that is the newest.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.type_name: str | None = None
        self.count = self.undecodable = self.total_bytes = self.last_bytes = 0
        self.values: dict[str, Any] | None = None
        self.decodes = False
        self._lcm_class: type | None = None
        self._stamps = Span()
        self._arrivals = Span()
        self._seqs = Span()

    def hear(self, heard: Heard, told: str | None) -> None:
        """Count a message, whose type somebody may have told."""
        self.count += 1
        self.last_bytes = len(heard.data)
        self.total_bytes += self.last_bytes
        self._arrivals.add(heard.at_s)
        values = self._decoded(heard.data, told)
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

    def _decoded(self, data: bytes, told: str | None) -> dict[str, Any] | None:
        if self._lcm_class is None or data[:8] != codec_of(self._lcm_class).fingerprint:
            self._lcm_class = (type_named(told) if told else None) or type_of(data)
            self.type_name = told or (codec_of(self._lcm_class).name if self._lcm_class else self.type_name)
        if self._lcm_class is None:
            return None
        try:
            return codec_of(self._lcm_class).decode(data)
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
