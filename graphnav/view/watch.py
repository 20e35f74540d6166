"""Everything that is known of what is watched: channels, runs, health, the robot's path; all of it bounded."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable

import graphnav_lcm

from graphnav.codec import type_named
from graphnav.graph.wiring.channels import RESERVED
from graphnav.messages import About
from graphnav.record import ABOUT
from graphnav.spy import Health, Received
from graphnav.spy.adapted_types import load_adapted_types
from graphnav.view.announcements import Announcements
from graphnav.view.channel import WatchedChannel
from graphnav.view.message_types import Kind, Kinds
from graphnav.view.robot_track import RobotTrack

_MAX_CHANNELS = 256
_MAX_ANNOUNCED = 1024
_FORGET_S = 60.0
_FORGET_EVERY_S = 1.0
_MAX_MESSAGE_BYTES = 16 << 20
_MAX_KEPT_BYTES = 64 << 20
_MAX_STAMPS = 256
_MAX_RUNS = 16
_MAX_STATUS_BYTES = 1 << 18
_HEALTH = (graphnav_lcm.status_t, graphnav_lcm.guard_state_t)


class Watch:
    """What was received so far; the owner's lock guards it.

    ``clock`` returns the time now in seconds on the clock of the arrivals. ``count`` and ``undecodable`` are of all
    messages, of channels that were forgotten, too. ``untracked`` counts the messages of
    channels beyond the first 256; channels that a run announced are always among them, up to 1024.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self.clock = clock
        self.channels: dict[str, WatchedChannel] = {}
        self.count = self.undecodable = self.untracked = 0
        self.health = Health(clock)
        self.announcements = Announcements()
        self.track = RobotTrack()
        self.map_channel: str | None = None
        self._announced: set[str] = set()
        self._kinds = Kinds()
        self._first_s: OrderedDict[int, float] = OrderedDict()
        self._kept_bytes = 0
        self._forgot_s = 0.0
        load_adapted_types()

    def receive(self, received: Received) -> None:
        """Take a message; whatever it holds, nothing is raised."""
        self.count += 1
        kind = self._kinds.of(received.data)
        is_decodable = kind is not None and len(received.data) >= kind.min_bytes
        self.undecodable += not is_decodable
        if received.channel == ABOUT and (about := self.announcements.receive(received)) is not None:
            self._expect(about)
        channel = self.channels.get(received.channel) or self._admit(received)
        if channel is None:
            self.untracked += 1
            return
        utime = channel.receive(received, kind)
        if kind is None or not is_decodable:
            return
        self._keep_newest(channel, received)
        if utime is not None and not received.channel.startswith(RESERVED):
            channel.add_latency(self._latency_s(utime, received.at_s))
        self._use(received, kind)

    def has_poses(self, data: bytes) -> bool:
        """Whether a message is one of those that make the robot's path."""
        kind = self._kinds.of(data)
        return kind is not None and self.track.follows(kind)

    def _use(self, received: Received, kind: Kind) -> None:
        """Read what is always shown: the health of runs and guards, the robot's pose, where the map is."""
        if kind.lcm_class in _HEALTH and len(received.data) <= _MAX_STATUS_BYTES:
            self.health.receive(received)
            runs = self.health.runs
            while len(runs) > _MAX_RUNS:
                del runs[min(runs, key=lambda run_id: runs[run_id].received_s)]
        elif kind.lcm_class is graphnav_lcm.map_t:
            self.map_channel = received.channel
        else:
            self.track.receive(received, kind)

    def _expect(self, about: About) -> None:
        """Make room for the channels that a run announces, and find their types."""
        if len(self._announced) > _MAX_ANNOUNCED:
            self._announced.clear()
        for name, type_name in list(zip(about.channels, about.types, strict=False))[:_MAX_ANNOUNCED]:
            if type_name.count(".") == 1:  # of a deeper name the search alone would import the package
                type_named(type_name)  # imports a package that lcm-gen made, so that its fingerprint is known
            self._announced.add(name)
            if name not in self.channels and len(self.channels) < _MAX_ANNOUNCED:
                self.channels[name] = WatchedChannel(name, type_name)

    def _admit(self, received: Received) -> WatchedChannel | None:
        """Return a new channel, None when full."""
        if received.channel in self._announced:
            room = _MAX_ANNOUNCED
        else:
            room = _MAX_CHANNELS
            if len(self.channels) >= room and received.at_s - self._forgot_s > _FORGET_EVERY_S:
                self._forget_silent(received.at_s)
        if len(self.channels) >= room:
            return None
        channel = self.channels[received.channel] = WatchedChannel(received.channel)
        return channel

    def _forget_silent(self, now_s: float) -> None:
        self._forgot_s = now_s
        for name in [
            n for n, c in self.channels.items() if now_s - c.received_s > _FORGET_S and n not in self._announced
        ]:
            newest = self.channels.pop(name).newest
            self._kept_bytes -= len(newest.data) if newest else 0

    def _keep_newest(self, channel: WatchedChannel, received: Received) -> None:
        """Keep a message as its channel's newest, unless it is too large to keep beside the others."""
        self._kept_bytes -= len(channel.newest.data) if channel.newest else 0
        n_bytes = len(received.data)
        channel.is_too_large = n_bytes > _MAX_MESSAGE_BYTES or self._kept_bytes + n_bytes > _MAX_KEPT_BYTES
        channel.newest = None if channel.is_too_large else received
        self._kept_bytes += 0 if channel.is_too_large else n_bytes

    def _latency_s(self, utime: int, at_s: float) -> float:
        """Return how long after the first message of its stamp a message came."""
        first_s = self._first_s.setdefault(utime, at_s)
        if len(self._first_s) > _MAX_STAMPS:
            self._first_s.popitem(last=False)
        return max(0.0, at_s - first_s)
