"""The LCM channels offered to clients: types, topics, newest messages, with bounded memory."""

from __future__ import annotations

from dataclasses import dataclass, field

from graphnav import About, Message, Scan
from graphnav.core.codec import type_named
from graphnav.watch.export.entries.message_entries import may_have_picture
from graphnav.watch.export.foxglove import FoxgloveChannels
from graphnav.watch.export.reader import MessageTypes
from graphnav.watch.view.foxglove.arrivals import Arrival

_MAX_CHANNELS = 240
"""All topics are sent to a client at once, and must fit the SDK's queue."""
_FORGET_US = 60_000_000
_FORGET_EVERY_US = 1_000_000
_MAX_KEPT_BYTES = 64 << 20


@dataclass
class ShownChannel:
    """A channel of a known type; ``newest``: its newest message, unless the store is full."""

    name: str
    lcm_class: type
    message_type: type[Message] | None
    topics: tuple[str, ...]
    newest: Arrival | None = None
    received_us: int = field(default=0)


class ShownChannels:
    """At most 240 channels, by name and by topic; new channels replace silent ones, announced ones any others."""

    def __init__(self, foxglove: FoxgloveChannels, types: MessageTypes) -> None:
        self._foxglove, self._types = foxglove, types
        self._by_name: dict[str, ShownChannel] = {}
        self._by_topic: dict[str, ShownChannel] = {}
        self._announced: set[str] = set()
        self._kept_bytes = 0
        self._forgot_us = 0

    def of_topic(self, topic: str) -> ShownChannel | None:
        """Return the channel that a topic belongs to."""
        return self._by_topic.get(topic)

    def named(self, name: str) -> ShownChannel | None:
        """Return a channel."""
        return self._by_name.get(name)

    def receive(self, arrival: Arrival, lcm_class: type) -> ShownChannel | None:
        """Return the channel of a message, offered from now on; None when full."""
        channel = self.offer(arrival.channel, lcm_class, arrival.utime)
        if channel is None:
            return None
        channel.received_us = arrival.utime
        self._kept_bytes -= channel.newest.n_bytes if channel.newest else 0
        channel.newest = arrival if self._kept_bytes + arrival.n_bytes <= _MAX_KEPT_BYTES else None
        self._kept_bytes += channel.newest.n_bytes if channel.newest else 0
        return channel

    def offer(self, name: str, lcm_class: type, now_us: int) -> ShownChannel | None:
        """Offer the topics of a channel, replacing those of a previous type; None when full."""
        channel = self._by_name.get(name)
        if channel is not None and channel.lcm_class is lcm_class:
            return channel
        if channel is not None:
            self.withdraw(name)
        elif len(self._by_name) >= _MAX_CHANNELS and not self._make_room(name, now_us):
            return None
        message_type = self._types.message_type(lcm_class)
        self._foxglove.offer_scalars(name, lcm_class)
        topics = [self._foxglove.scalars_topic(name)]
        if may_have_picture(message_type):
            self._foxglove.offer_picture(name)
            topics.append(self._foxglove.picture_topic(name))
        if message_type is not None and issubclass(message_type, Scan):
            self._foxglove.offer_beams(name)
            topics.append(self._foxglove.beams_topic(name))
        channel = self._by_name[name] = ShownChannel(name, lcm_class, message_type, tuple(topics))
        self._by_topic.update(dict.fromkeys(topics, channel))
        return channel

    def announce(self, about: About, now_us: int) -> None:
        """Offer the channels announced by a new run, replacing those of the previous run."""
        announced = dict(zip(about.channels[:_MAX_CHANNELS], about.types, strict=False))
        for name in self._announced - announced.keys():
            self.withdraw(name)
        self._announced = set(announced)
        for name, type_name in announced.items():
            # searching for a deeper name would import the package
            lcm_class = type_named(type_name) if type_name.count(".") == 1 else None
            if lcm_class is not None:
                self.offer(name, lcm_class, now_us)

    def forget_newest(self) -> None:
        """Drop all messages, for another time of the log or another run."""
        for channel in self._by_name.values():
            channel.newest = None
        self._kept_bytes = 0

    def withdraw(self, name: str) -> None:
        """Close the topics of a channel."""
        channel = self._by_name.pop(name, None)
        if channel is None:
            return
        self._kept_bytes -= channel.newest.n_bytes if channel.newest else 0
        for topic in channel.topics:
            del self._by_topic[topic]
        self._foxglove.withdraw_channel(name)

    def _make_room(self, name: str, now_us: int) -> bool:
        """Withdraw silent channels; for an announced channel, otherwise one that was not announced."""
        if self._forget_silent(now_us):
            return True
        others = [channel for channel in self._by_name.values() if channel.name not in self._announced]
        if name not in self._announced or not others:
            return False
        self.withdraw(min(others, key=lambda channel: channel.received_us).name)
        return True

    def _forget_silent(self, now_us: int) -> bool:
        """Withdraw the channels that were silent for a minute; return whether there were any."""
        if now_us - self._forgot_us < _FORGET_EVERY_US:
            return False
        self._forgot_us = now_us
        silent = [channel.name for channel in self._by_name.values() if now_us - channel.received_us > _FORGET_US]
        for name in silent:
            self.withdraw(name)
        return bool(silent)
