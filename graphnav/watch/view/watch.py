"""The state of a watched source: channels, runs, health, the robot's path, with bounded memory."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable

import graphnav_lcm

from graphnav.core.catalog import Catalog
from graphnav.core.codec import type_named
from graphnav.core.graph.wiring.channels import RESERVED
from graphnav.core.messages import About
from graphnav.core.record import ABOUT
from graphnav.watch.spy import Health, Received
from graphnav.watch.view.announcements import Announcements
from graphnav.watch.view.channel import WatchedChannel
from graphnav.watch.view.message_types import Kind, Kinds
from graphnav.watch.view.robot_track import RobotTrack

_MAX_CHANNELS = 256
_MAX_ANNOUNCED = 1024
_FORGET_S = 60.0
_FORGET_EVERY_S = 1.0
_MAX_MESSAGE_BYTES = 16 << 20
_MAX_KEPT_BYTES = 64 << 20
_MAX_STAMPS = 256
_MAX_RUNS = 16
_MAX_TRACKS = 64
_MAX_STATUS_BYTES = 1 << 18
_HEALTH = (graphnav_lcm.status_t, graphnav_lcm.guard_state_t)


class Watch:
    """The messages received so far; guarded by the owner's lock.

    ``clock`` returns the current time, seconds, on the arrival clock. ``count`` and ``undecodable`` include the
    messages of forgotten channels. ``untracked`` counts the messages of channels beyond the first 256; announced
    channels are always tracked, up to 1024.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self.clock = clock
        self.channels: dict[str, WatchedChannel] = {}
        self.count = self.undecodable = self.untracked = 0
        self.health = Health(clock)
        self.announcements = Announcements()
        self._tracks: dict[str, RobotTrack] = {}
        self._announced: set[str] = set()
        self._kinds = Kinds()
        self._first_s: OrderedDict[int, float] = OrderedDict()
        self._kept_bytes = 0
        self._forgot_s = 0.0
        Catalog().load_types()

    def receive(self, received: Received) -> None:
        """Process a message; invalid messages never raise."""
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

    def channels_of(self, run_id: str | None) -> dict[str, WatchedChannel]:
        """Return the channels of a run and those that no run has announced, such as a camera's; None: all channels."""
        runs = self.announcements.runs
        if run_id is None:
            return self.channels
        foreign = {name for other, one in runs.items() if other != run_id for name in one.about.channels}
        foreign -= {*runs[run_id].about.channels}
        return {name: channel for name, channel in self.channels.items() if name not in foreign}

    def track_of(self, run_id: str | None) -> RobotTrack:
        """Return the path of a run's robot: true states if available, else odometry; the first of several channels."""
        shown = self.channels_of(run_id)
        tracks = (track for channel, track in self._tracks.items() if channel in shown)
        return max(tracks, key=lambda track: track.rank, default=RobotTrack())

    def has_poses(self, data: bytes) -> bool:
        """Whether a message is a pose of the robot's path."""
        kind = self._kinds.of(data)
        return kind is not None and RobotTrack.follows(kind)

    def _use(self, received: Received, kind: Kind) -> None:
        """Process messages that are always shown: health of runs and guards, the robot's pose."""
        if kind.lcm_class in _HEALTH and len(received.data) <= _MAX_STATUS_BYTES:
            self.health.receive(received)
            runs = self.health.runs
            while len(runs) > _MAX_RUNS:
                del runs[min(runs, key=lambda run_id: runs[run_id].received_s)]
        elif RobotTrack.follows(kind) and (received.channel in self._tracks or len(self._tracks) < _MAX_TRACKS):
            self._tracks.setdefault(received.channel, RobotTrack(received.channel)).receive(received, kind)

    def _expect(self, about: About) -> None:
        """Register the channels announced by a run, with their types."""
        if len(self._announced) > _MAX_ANNOUNCED:
            self._announced.clear()
        for name, type_name in list(zip(about.channels, about.types, strict=False))[:_MAX_ANNOUNCED]:
            if type_name.count(".") == 1:  # of a deeper name the search alone would import the package
                type_named(type_name)  # imports a package generated by lcm-gen, so that its fingerprint is known
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
            self._tracks.pop(name, None)
            newest = self.channels.pop(name).newest
            self._kept_bytes -= len(newest.data) if newest else 0

    def _keep_newest(self, channel: WatchedChannel, received: Received) -> None:
        """Store a message as its channel's newest, unless the memory limit is reached."""
        self._kept_bytes -= len(channel.newest.data) if channel.newest else 0
        n_bytes = len(received.data)
        channel.is_too_large = n_bytes > _MAX_MESSAGE_BYTES or self._kept_bytes + n_bytes > _MAX_KEPT_BYTES
        channel.newest = None if channel.is_too_large else received
        self._kept_bytes += 0 if channel.is_too_large else n_bytes

    def _latency_s(self, utime: int, at_s: float) -> float:
        """Return the delay of a message after the first message of its timestamp."""
        first_s = self._first_s.setdefault(utime, at_s)
        if len(self._first_s) > _MAX_STAMPS:
            self._first_s.popitem(last=False)
        return max(0.0, at_s - first_s)
