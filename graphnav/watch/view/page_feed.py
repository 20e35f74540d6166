"""The feed of the page, live or a log that is played, and its state: channels, runs, health and paths."""

from __future__ import annotations

import time
from itertools import chain

import graphnav_lcm

from graphnav.watch.channel_account import Clock, Kind
from graphnav.watch.feed import Feed, Health, LiveFeed, LogFeed, Past, Received, Watch, WatchedChannel
from graphnav.watch.view.robot_track import RobotTrack

_BEFORE_S = 10.0
"""The part of a log before the target of a jump that is played at once, to compute rates."""
_MAX_TRACKS = 64
_MAX_STATUS_BYTES = 1 << 18
_HEALTH = (graphnav_lcm.status_t, graphnav_lcm.guard_state_t)
_MAX_TOLD = 3


class PageState:
    """The messages received so far. ``clock`` returns the current time, seconds, on the arrival clock."""

    def __init__(self, clock: Clock) -> None:
        self.clock = clock
        self.watch = Watch(clock)
        self.health = Health(clock)
        self._tracks: dict[str, RobotTrack] = {}

    def receive(self, received: Received) -> None:
        """Process a message; invalid ones never raise."""
        channel = self.watch.receive(received)
        if channel.kind is None or not channel.decodes or channel.name not in self.watch.channels:
            return
        self._use(received, channel.kind)

    def channels_of(self, run_id: str | None) -> dict[str, WatchedChannel]:
        """Return the channels of a run and those that no run has announced, such as a camera's; None: all channels."""
        runs, channels = self.watch.announcements.runs, self.watch.channels
        if run_id is None:
            return channels
        foreign = {name for other, one in runs.items() if other != run_id for name in one.about.channels}
        foreign -= {*runs[run_id].about.channels}
        return {name: channel for name, channel in channels.items() if name not in foreign}

    def track_of(self, run_id: str | None) -> RobotTrack:
        """Return the path of a run's robot: true states if available, else odometry; the first of several channels."""
        shown = self.channels_of(run_id)
        tracks = (track for channel, track in self._tracks.items() if channel in shown)
        return max(tracks, key=lambda track: track.rank, default=RobotTrack())

    def _use(self, received: Received, kind: Kind) -> None:
        """Process messages that are always shown: health of runs and guards, the robot's pose."""
        if kind.lcm_class in _HEALTH and len(received.data) <= _MAX_STATUS_BYTES:
            self.health.receive(received)
        elif RobotTrack.follows(kind) and (received.channel in self._tracks or len(self._tracks) < _MAX_TRACKS):
            self._tracks.setdefault(received.channel, RobotTrack(received.channel)).receive(received, kind)


class PageFeed:
    """A feed and the state of what it has sent, which readers use with ``lock`` held.

    ``state`` is another one after a jump in a log. ``log``: the player of a log, None for a live feed; ``damage``: what
    of the log is damaged. Raises LogError if a log cannot be read, GraphnavError if it is empty.
    """

    def __init__(self, feed: Feed) -> None:
        self.name, self.damage = feed.name, ""
        self.log = None if feed.is_live else LogFeed(feed, self._take, self._jump, _BEFORE_S, "graphnav-view")
        self._feed = self.log or LiveFeed(feed, self._take, name="graphnav-view")
        self.lock = self._feed.lock
        self.state = self._new_state()
        if self.log is not None:
            recording = self.log.recording
            lost = [*map(str, recording.damaged), *([str(recording.truncated)] if recording.truncated else [])]
            more = f"; and {len(lost) - _MAX_TOLD} more" if lost[_MAX_TOLD:] else ""
            self.damage = "; ".join(lost[:_MAX_TOLD]) + more

    @property
    def failure(self) -> str:
        """Why nothing is received, in one line; empty while it is."""
        return "; ".join(line.strip() for line in self._feed.failure.splitlines())

    @property
    def losses(self) -> str:
        """A phrase about what another computer has dropped in place of sending it; empty if there is nothing."""
        return self._feed.losses

    def dropped_packets(self) -> int:
        """Return the number of packets dropped by the kernel; 0 for a log."""
        return self._feed.dropped_packets()

    def start(self) -> None:
        """Start to receive, or to play."""
        self._feed.start()
        if self.log is not None:
            self.log.play()

    def close(self) -> None:
        """Stop; close the network or the file."""
        self._feed.close()

    def _new_state(self) -> PageState:
        log = self.log
        return PageState(time.monotonic if log is None else lambda: log.at_s)

    def _take(self, received: Received) -> None:
        self.state.receive(received)

    def _jump(self, past: Past) -> None:
        self.state = self._new_state()
        for received in chain(past.poses, past.newest):
            self.state.receive(received)
