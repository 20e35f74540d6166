"""Read a log once, from beginning to end, and summarise it: its channels, and whether its run finished."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from graphnav import Recording
from graphnav.core.codec import DecodeError
from graphnav.core.errors import LogError
from graphnav.core.messages import Gap
from graphnav.core.record import Damaged, TruncatedEvent
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import ProgressFile
from graphnav.watch.channel_account import ChannelCounts, kind_of
from graphnav.watch.loginfo.log_origin import LogOrigin, origin_of

_WALL_US = 1_000_000_000_000_000
"""Stamps from September 2001 on are wall time; simulated time begins at 0."""
_FINGERPRINT_BYTES = 8


def unfinished(log: Path) -> str:
    """Return that the run of a log did not finish, and its last call into a stage as far as that is known.

    Empty if it finished, or if the log is not that of a run folder.
    """
    folder = log.parent
    if log.name != RunFolder.LOG or not (folder / RunFolder.GRAPH).is_file() or (folder / RunFolder.SUMMARY).is_file():
        return ""
    if ProgressFile.is_running(folder):
        return "the run has not finished: its process still runs"
    call = ProgressFile.last_call(folder)
    return "the run did not finish: its process ended early" + (
        f"; the last call was {call}" if call is not None else ""
    )


class ChannelInfo(ChannelCounts):
    """The messages of one channel; its times are seconds since the first event of the log.

    ``kind``: the type of the first message of a known type, None without one; ``type_name``: its name, or the one that
    the log itself gives. ``fingerprint``: the first 8 bytes of a message, fewer if it is shorter. ``undecodable``:
    messages that are damaged or not of the channel's type.
    """

    def __init__(self, name: str, data: bytes) -> None:
        super().__init__()
        self.name = name
        self.undecodable = 0
        self._declared: str | None = None
        self._take_type(data)

    def take(self, data: bytes, at_s: float) -> None:
        """Count a message."""
        if self.kind is None and data[:_FINGERPRINT_BYTES] != self.fingerprint and kind_of(data) is not None:
            self._take_type(data)
            self.undecodable = self.count
        self.add(len(data), at_s)
        if not self._is_readable(data):
            self.undecodable += 1
        elif self.kind is not None and self.kind.is_stamped and (stamp := self.kind.stamp(data)) is not None:
            self.gaps.see(stamp[1])

    @property
    def fingerprint_hex(self) -> str | None:
        """The fingerprint in hex, None if the message is too short for one."""
        return self.fingerprint.hex() if len(self.fingerprint) == _FINGERPRINT_BYTES else None

    def declare(self, type_name: str | None) -> None:
        """Take the type that the log itself gives, if its definition is not installed."""
        self._declared = type_name

    @property
    def type_name(self) -> str | None:
        """The LCM name of the type, None if it is unknown."""
        return self.kind.name if self.kind is not None else self._declared

    @property
    def lost(self) -> int | None:
        """The number of missing sequence numbers, None if messages have none."""
        return self.gaps.lost if self.kind is not None and self.kind.is_stamped else None

    @property
    def lost_since_restart(self) -> int | None:
        """The number of missing sequence numbers since a sender restarted them, None if messages have none."""
        return None if self.lost is None else self.gaps.lost_since_restart

    @property
    def n_restarts(self) -> int | None:
        """How often the numbering restarted, None if messages have no numbers."""
        return None if self.lost is None else max(0, self.gaps.n_restarts)

    def _take_type(self, data: bytes) -> None:
        self.fingerprint, self.kind = data[:_FINGERPRINT_BYTES], kind_of(data)

    def _is_readable(self, data: bytes) -> bool:
        if self.kind is None:
            return len(self.fingerprint) < _FINGERPRINT_BYTES or data.startswith(self.fingerprint)
        try:
            self.kind.codec.decode(data)
        except DecodeError:
            return False
        return True


@dataclass(frozen=True)
class LogInfo:
    """The summary of a log; ``n_jumps`` counts timestamps that jump."""

    path: Path
    n_bytes: int
    n_messages: int
    begin_us: int
    duration_us: int
    n_jumps: int
    channels: list[ChannelInfo]
    origin: LogOrigin | None
    completion_hint: str
    """How to make again what the log leaves out, see `Recording`."""
    damaged: list[Damaged]
    truncated: TruncatedEvent | None
    gaps: tuple[tuple[int, Gap], ...] = ()
    """Gaps in the recording, and the timestamps at which the log goes on, microseconds."""
    silent: tuple[str, ...] = ()
    """The topics of a ROS 2 bag without messages."""
    unfinished: str = ""
    """That the run did not finish, empty if it did or that is not known."""

    @property
    def is_wall_time(self) -> bool:
        """Whether the stamps of the log are wall time."""
        return self.begin_us >= _WALL_US

    @property
    def undecodable(self) -> int:
        """The number of undecodable messages on all channels."""
        return sum(channel.undecodable for channel in self.channels)


def survey(path: Path) -> LogInfo:
    """Return the summary of a log; reads the complete file, one message at a time.

    Raises LogError if the file cannot be read or is not a log.
    """
    with Recording(path) as recording:
        channels: dict[str, ChannelInfo] = {}
        for event, at_us in zip(recording.events(), recording.timeline.at_us, strict=True):
            if event.channel not in channels:
                is_foreign = event.channel in recording.foreign_types  # its bytes are not those of LCM
                channels[event.channel] = ChannelInfo(event.channel, b"" if is_foreign else event.data)
            channels[event.channel].take(event.data, at_us / 1e6)
        about = recording.about
        for name, type_name in zip(about.channels, about.types, strict=False) if about is not None else ():
            if name in channels:
                channels[name].declare(type_name)
        for topic, ros_type in recording.foreign_types.items():
            channels[topic].declare(ros_type)
        return LogInfo(
            path=path,
            n_bytes=recording.n_bytes,
            n_messages=recording.n_events,
            begin_us=recording.begin_us,
            duration_us=recording.timeline.duration_us,
            n_jumps=recording.timeline.n_jumps,
            channels=[channels[name] for name in sorted(channels)],
            origin=origin_of(recording),
            completion_hint=recording.completion_hint,
            damaged=recording.damaged,
            truncated=recording.truncated,
            gaps=_gaps(recording),
            unfinished=unfinished(path),
            silent=_silent_topics(recording),
        )


def _silent_topics(recording: Recording) -> tuple[str, ...]:
    bag = recording.bag
    return () if bag is None else tuple(topic for topic in bag.types if not recording.count(topic))


def _gaps(recording: Recording) -> tuple[tuple[int, Gap], ...]:
    try:
        found = [(utime, gap) for utime, _, gap in recording.messages(Gap.CHANNEL) if isinstance(gap, Gap)]
    except LogError:
        return ()
    return tuple(found)
