"""The state of a watched feed: all its channels with their newest messages, and the runs that announce themselves."""

from __future__ import annotations

from graphnav import About, GraphnavError, UserError, did_you_mean
from graphnav.core.catalog import Catalog
from graphnav.core.codec import type_named
from graphnav.core.errors import Hint, shown_name
from graphnav.core.graph import RESERVED
from graphnav.watch.channel_account import Clock, FirstArrivals
from graphnav.watch.feed.announcements import RUN_SILENT_S, Announcements
from graphnav.watch.feed.channel import WatchedChannel
from graphnav.watch.feed.feed import Feed, Received, drops_of

MAX_CHANNELS = 512
"""Messages of further channels are only counted, to bound memory when a program sends random names."""
_MAX_ANNOUNCED = 1024
_FORGET_S = 60.0
_FORGET_EVERY_S = 1.0
_MAX_NEWEST_BYTES = 128 << 20
_MAX_SMALL_BYTES = 64 << 20
_MAX_NAMED = 12
"""Further channels are not named in an error."""


class Watch:
    """All channels, by name, received or announced, and the announced runs, in bounded memory; not thread-safe.

    There are at most 512 channels, and those that a run announces, up to 1024 together, and ``wanted``. While there is
    no room, channels that were silent for a minute are forgotten. ``overflow`` counts the messages of channels without
    room and of forgotten ones; ``count`` and ``undecodable`` include them. The newest messages of all channels but
    ``wanted`` have room for 134 MB, the small ones of all histories for 67 MB.

    ``clock`` returns the current time, seconds, on the arrival clock; with a clock rates are those of the last 10 s.
    Without a clock, as for a log, no channel is silent and rates are those of the newest 10,000 messages.
    """

    def __init__(self, clock: Clock | None = None, wanted: str | None = None) -> None:
        self.channels: dict[str, WatchedChannel] = {}
        self.announcements = Announcements()
        self.overflow = self.count = self.undecodable = 0
        self._clock, self._wanted = clock, wanted
        self._announced: set[str] = set()
        self._first_arrivals = FirstArrivals()
        self._newest_bytes = self._small_bytes = 0
        self._forgot_s = 0.0
        Catalog().load_types()

    def receive(self, received: Received) -> WatchedChannel:
        """Process a message; invalid ones never raise. Return its channel, a temporary one where there is no room."""
        self.count += 1
        if received.channel == About.CHANNEL and (about := self.announcements.receive(received)) is not None:
            self._expect(about)
        channel = self.channels.get(received.channel) or self._admit(received)
        if channel is None:
            self.overflow += 1
            channel = WatchedChannel(received.channel, clock=self._clock)
        else:
            self._newest_bytes -= channel.n_newest_bytes
            self._small_bytes -= channel.n_small_bytes
        utime = channel.receive(received.data, received.at_s)
        channel.rates.add(received.at_s)
        self.undecodable += not channel.decodes
        if channel.decodes:
            room_bytes = _MAX_NEWEST_BYTES - self._newest_bytes
            small_room_bytes = _MAX_SMALL_BYTES - self._small_bytes - channel.n_small_bytes
            channel.keep(received, len(received.data) if channel.name == self._wanted else room_bytes, small_room_bytes)
        if self.channels.get(received.channel) is channel:
            self._newest_bytes += channel.n_newest_bytes
            self._small_bytes += channel.n_small_bytes
            if utime is not None and not received.channel.startswith(RESERVED):
                channel.add_pipeline_delay(self._first_arrivals.delay_s(utime, received.at_s))
        return channel

    def newest(self, name: str) -> Received | None:
        """Return the newest complete message of a channel of a known type."""
        channel = self.channels.get(name)
        return None if channel is None else channel.newest

    def recent(self, name: str, after_s: float) -> list[Received]:
        """Return the stored small messages of a channel that arrived after ``after_s``, oldest first."""
        channel = self.channels.get(name)
        history = () if channel is None else channel.history
        return [received for _, received in history if received.at_s > after_s]

    def names_of(self, lcm_class: type) -> list[str]:
        """Return the channels whose newest message is of a type."""
        return [name for name, one in self.channels.items() if one.lcm_class is lcm_class and one.newest is not None]

    def find(self, name: str, feed: Feed, for_s: float | None) -> WatchedChannel:
        """Return a channel of which a message was received.

        Raises UserError if the feed does not have the channel, GraphnavError if no message was received.
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

    def _expect(self, about: About) -> None:
        """Register the channels announced by a run, with their types."""
        if len(self._announced) > _MAX_ANNOUNCED:
            self._announced.clear()
        for name, type_name in list(zip(about.channels, about.types, strict=False))[:_MAX_ANNOUNCED]:
            if type_name.count(".") == 1:  # of a deeper name the search alone would import the package
                type_named(type_name)  # imports a package generated by lcm-gen, so that its fingerprint is known
            self._announced.add(name)
            channel = self.channels.get(name)
            if channel is not None:
                channel.type_name = channel.type_name or type_name
            elif len(self.channels) < _MAX_ANNOUNCED:
                self.channels[name] = WatchedChannel(name, type_name, self._clock)

    def _admit(self, received: Received) -> WatchedChannel | None:
        """Return a new channel, None when full."""
        is_expected = received.channel in self._announced or received.channel == self._wanted
        max_channels = _MAX_ANNOUNCED if is_expected else MAX_CHANNELS
        if len(self.channels) >= max_channels and received.at_s - self._forgot_s > _FORGET_EVERY_S:
            self._forget_silent(received.at_s)
        if len(self.channels) >= max_channels and received.channel != self._wanted:
            return None
        channel = self.channels[received.channel] = WatchedChannel(received.channel, clock=self._clock)
        return channel

    def _forget_silent(self, now_s: float) -> None:
        """Forget channels that other programs have stopped to send, unless the feed is a log."""
        self._forgot_s = now_s
        for name, channel in list(self.channels.items()) if self._clock is not None else ():
            if now_s - channel.received_s > _FORGET_S and name not in self._announced and name != self._wanted:
                del self.channels[name]
                self.overflow += channel.count
                self._newest_bytes -= channel.n_newest_bytes
                self._small_bytes -= channel.n_small_bytes
