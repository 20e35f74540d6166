"""The channels of a feed and the runs that announce themselves on it."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

from graphnav import GraphnavError, UserError, did_you_mean
from graphnav.core.catalog import Catalog
from graphnav.core.codec import DecodeError
from graphnav.core.errors import Hint, shown_name
from graphnav.core.record import ABOUT, ChannelAccount, Clock, Kind
from graphnav.watch.spy.announcements import RUN_SILENT_S, Announcements
from graphnav.watch.spy.feed import Feed, Received, drops_of
from graphnav.watch.spy.rate_history import RateHistory

MAX_CHANNELS = 512
"""Messages of further channels are only counted, to bound memory when a program sends random names."""
_MAX_NAMED = 12
"""Further channels are not named in an error."""


class Traffic:
    """All channels, by name, received or announced, and the announced runs.

    There are at most 512 channels, and ``wanted``; ``overflow`` counts the messages of all others. ``count`` and
    ``undecodable`` include these messages.
    ``clock`` returns the current time, seconds, on the arrival clock; with a clock rates are those of the last 10 s.
    Without a clock, as for a log, no channel is silent and rates are those of the newest 10,000 messages.
    """

    def __init__(self, clock: Clock | None = None, wanted: str | None = None) -> None:
        self._clock, self._wanted = clock, wanted
        self.channels: dict[str, ChannelTraffic] = {}
        self.announcements = Announcements()
        self.overflow = self.count = self.undecodable = 0
        Catalog().load_types()

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
        newest_s, channel = self.announcements.newest_s, self.channels.get(name)
        if newest_s is None or now_s - newest_s < RUN_SILENT_S:
            return None
        is_sending = channel is not None and now_s - channel.received_s < RUN_SILENT_S
        return None if is_sending else self.announcements.last_id

    def check(self, name: str, feed: Feed) -> None:
        """Raise UserError if the announced runs have no such channel: waiting would be futile."""
        if self.announcements.runs and name not in self.channels:
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
        channel.receive(received.data, received.at_s)
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
        about = self.announcements.receive(received)
        if about is None:
            return
        for name, type_name in zip(about.channels[:MAX_CHANNELS], about.types, strict=False):
            channel = self._channel(name, type_name)
            if channel is not None:
                channel.type_name = channel.type_name or type_name


class ChannelTraffic(ChannelAccount):
    """The account of one channel, its newest message, and its rate in the last seconds.

    The newest decodable message is decoded on access to ``values``.
    """

    def __init__(self, name: str, announced_type: str | None = None, clock: Clock | None = None) -> None:
        super().__init__(name, announced_type, clock)
        self.history = RateHistory()
        self._newest: bytes | None = None
        self._values: dict[str, Any] | None = None

    def receive(self, data: bytes, at_s: float) -> int | None:
        """Count a message, and keep it if it is complete; return its stamp if it is new."""
        utime = super().receive(data, at_s)
        self.history.add(at_s)
        if self.decodes:
            self._newest, self._values = data, None
        return utime

    def change_type(self, kind: Kind) -> None:
        """Take the type of a message as that of the channel; forget messages of another type."""
        super().change_type(kind)
        self._newest = self._values = None

    @property
    def values(self) -> dict[str, Any] | None:
        """The fields of the newest decodable message, None before the first."""
        if self._values is None and self._newest is not None and self.kind is not None:
            with suppress(DecodeError):  # sizes beyond what numpy can shape
                self._values = self.kind.codec.decode(self._newest)
        return self._values
