"""Convert received messages with subscribers to Foxglove messages."""

from __future__ import annotations

import time
from collections.abc import Collection, Iterable

from graphnav import About, GraphnavError, Map, Message, Odometry, Scan, Scene, State
from graphnav.core.catalog import Catalog
from graphnav.core.codec import DecodeError, codec_of
from graphnav.core.pictures import Pictures
from graphnav.watch.channel_account import kind_of
from graphnav.watch.export.entries.entries import Beams, Level, Line, Scalars, World
from graphnav.watch.export.entries.event_lines import LINE_TYPES, Lines, heading
from graphnav.watch.export.entries.message_entries import MessageEntries
from graphnav.watch.export.foxglove import LOG_TOPIC, TOPICS, FoxgloveChannels
from graphnav.watch.export.foxglove_scene import (
    MAP_TOPIC,
    PATH_TOPIC,
    POSE_TOPIC,
    ROBOT_TOPIC,
    TRANSFORM_TOPIC,
)
from graphnav.watch.export.reader import MessageTypes
from graphnav.watch.feed import Announcements, Received
from graphnav.watch.view.foxglove.arrivals import Arrival, Batch
from graphnav.watch.view.foxglove.losses import Losses, Reason
from graphnav.watch.view.foxglove.message_history import MessageHistory
from graphnav.watch.view.foxglove.shown_channels import ShownChannel, ShownChannels

_PATH_EVERY_S = 1.0
_POSE_TOPICS = (POSE_TOPIC, TRANSFORM_TOPIC)


class Converter:
    """Converts messages and logs them to the topics of ``foxglove``; used by one thread.

    A message is decoded only if a client has subscribed to one of its topics. Invalid messages never raise. ``source``:
    the name of the feed in lines of text.
    """

    def __init__(self, foxglove: FoxgloveChannels, catalog: Catalog, source: str) -> None:
        self.losses = Losses()
        self._foxglove, self._source = foxglove, source
        self._types = MessageTypes(catalog)
        self.channels = ShownChannels(foxglove, self._types)
        self._past = MessageHistory(self._types)
        self._messages = MessageEntries(Pictures(catalog), self._past)
        self._lines = Lines()
        self._announcements = Announcements()
        self._about: About | None = None
        self._world: tuple[str, bytes] | None = None
        self._path_due_s = 0.0
        self._now_us = 0
        for topic in TOPICS:
            foxglove.offer(topic)

    def show(self, batch: Batch) -> None:
        """Show a batch; only the newest message of each channel is drawn."""
        if batch.is_jump:
            self._reset()
            self.losses.forget_messages()
        if batch.n_dropped:
            self.losses.add(Reason.TOO_FAST, n=batch.n_dropped)
        newest = {arrival.channel: arrival for arrival in batch.arrivals}
        for arrival in batch.arrivals:
            self._receive(arrival, is_drawn=newest[arrival.channel] is arrival)
        if self._foxglove.is_wanted(LOG_TOPIC):
            self._tell(self.losses.due())

    def show_again(self, topics: Collection[str]) -> None:
        """Show the newest message of newly subscribed topics."""
        wanted = [topic for topic in topics if self._foxglove.is_wanted(topic)]
        shown = {channel.name: channel for topic in wanted if (channel := self.channels.of_topic(topic)) is not None}
        for channel in shown.values():
            self._show_newest(channel, [topic for topic in channel.topics if topic in wanted])
        if LOG_TOPIC in wanted:
            self._tell([text for text in [heading(self._about)] if text], Level.INFO)
            self._tell(self.losses.all())
        if MAP_TOPIC in wanted or ROBOT_TOPIC in wanted:
            self._show_world()
        pose_channel = self.channels.named(self._past.pose_channel or "")
        if pose_channel is not None and (topics := [topic for topic in _POSE_TOPICS if topic in wanted]):
            self._show_newest(pose_channel, topics)
        if PATH_TOPIC in wanted:
            self._show_path()

    def tell(self, lines: Iterable[Line]) -> None:
        """Log lines of text."""
        for line in lines:
            self._foxglove.add(line)

    def _receive(self, arrival: Arrival, *, is_drawn: bool) -> None:
        self._now_us = arrival.utime
        if arrival.channel == About.CHANNEL:
            self._receive_about(arrival)
        kind = kind_of(arrival.data)
        if kind is None:
            self.losses.add(Reason.UNKNOWN_TYPE, arrival.channel)
            return
        if len(arrival.data) < kind.min_bytes:
            self.losses.add(Reason.UNDECODABLE, arrival.channel)
            return
        channel = self.channels.receive(arrival, kind.lcm_class)
        if channel is None:
            self.losses.add(Reason.UNTRACKED)
            return
        if channel.message_type is not None:
            self._past.receive(arrival, kind.lcm_class, channel.message_type)
        if not arrival.is_past:
            self._show(channel, arrival, self._wanted(channel, is_drawn=is_drawn))
            self._show_along(channel, arrival)

    def _receive_about(self, arrival: Arrival) -> None:
        """Detect a new run, whose announcement replaces the previous one."""
        about = self._announcements.receive(Received(arrival.channel, arrival.data, arrival.utime / 1e6))
        if about is None or (self._about is not None and about.run_id == self._about.run_id):
            return
        if self._about is not None:
            self._reset()
        self._about = about
        self.channels.announce(about, arrival.utime)
        if self._foxglove.is_wanted(LOG_TOPIC):
            self._tell([text for text in [heading(about)] if text], Level.INFO)

    def _reset(self) -> None:
        """Clear the history, for another run or another time of the log."""
        self._past.forget()
        self.channels.forget_newest()
        self._lines = Lines()
        self._path_due_s = 0.0

    def _wanted(self, channel: ShownChannel, *, is_drawn: bool) -> list[str]:
        """Return the topics for which a channel's messages must be decoded."""
        topics = list(channel.topics if is_drawn else channel.topics[:1])
        if channel.message_type in LINE_TYPES:
            topics.append(LOG_TOPIC)
        if channel.name == self._past.pose_channel:
            topics += _POSE_TOPICS
        return [topic for topic in topics if self._foxglove.is_wanted(topic)]

    def _show_newest(self, channel: ShownChannel, topics: list[str]) -> None:
        if channel.newest is not None:
            self._show(channel, channel.newest, topics)

    def _show(self, channel: ShownChannel, arrival: Arrival, topics: list[str]) -> None:
        """Show a message of a channel on some of its topics."""
        if not topics:
            return
        try:
            fields = codec_of(channel.lcm_class).decode(arrival.data)
        except DecodeError:
            self.losses.add(Reason.UNDECODABLE, channel.name)
            return
        scalars_topic = channel.topics[0]
        if scalars_topic in topics:
            self._foxglove.add(Scalars(channel.name, arrival.utime, channel.lcm_class, fields))
        if topics == [scalars_topic] or channel.message_type is None:
            return
        message = self._types.message(channel.lcm_class, fields)
        if message is None:
            self.losses.add(Reason.UNDECODABLE, channel.name)
            return
        if channel.topics[-1] in topics and channel.topics[-1] != scalars_topic:
            if isinstance(message, Scan):
                self._foxglove.add(Beams(channel.name, arrival.utime, message))
            else:
                self._show_picture(channel, arrival.utime, message)
        if LOG_TOPIC in topics:
            self.tell(self._lines.of(channel.name, arrival.utime, message))
        if not set(_POSE_TOPICS).isdisjoint(topics) and isinstance(message, State | Odometry):
            pose = self._messages.pose(arrival.utime, message)
            if pose is not None:
                self._foxglove.add(pose)

    def _show_picture(self, channel: ShownChannel, utime: int, message: Message) -> None:
        self._messages.undrawn.pop(channel.name, None)
        try:
            picture = self._messages.picture(channel.name, utime, message)
        except GraphnavError as error:
            self.losses.add(Reason.UNDRAWN, channel.name, str(error))
            return
        if picture is not None:
            self._foxglove.add(picture)
        elif channel.name in self._messages.undrawn:
            self.losses.add(Reason.UNDRAWN, channel.name, self._messages.undrawn[channel.name])

    def _show_along(self, channel: ShownChannel, arrival: Arrival) -> None:
        """Show what a message changes on other topics: the map, the path."""
        if channel.name == self._past.channel_of(Map) and self._world != (channel.name, arrival.data):
            self._world = channel.name, arrival.data
            if self._foxglove.is_wanted(MAP_TOPIC) or self._foxglove.is_wanted(ROBOT_TOPIC):
                self._show_world()
        if channel.name == self._past.pose_channel and self._foxglove.is_wanted(PATH_TOPIC):
            now_s = time.monotonic()
            if now_s >= self._path_due_s:
                self._path_due_s = now_s + _PATH_EVERY_S
                self._show_path()

    def _show_world(self) -> None:
        """Show the map and the robot's shape."""
        world = self._past.find(Map)
        scene = None if world is None else Scene(world)
        if scene is not None:
            self._foxglove.add(World(self._now_us, scene))
        if scene is not None or self._past.pose_channel is not None:
            self._foxglove.add(self._messages.robot(self._now_us, scene))

    def _show_path(self) -> None:
        path = self._messages.path(self._now_us)
        if path is not None:
            self._foxglove.add(path)

    def _tell(self, texts: list[str], level: Level = Level.WARNING) -> None:
        self.tell(Line(self._now_us, level, text, self._source) for text in texts)
