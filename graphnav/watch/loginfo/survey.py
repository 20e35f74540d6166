"""Read a log once, from beginning to end, and summarise it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from graphnav.core.codec import Codec, DecodeError, codec_of, lcm_name, type_of
from graphnav.core.errors import LogError
from graphnav.core.messages import Gap
from graphnav.core.record import GAP, Damaged, Recording, SequenceGaps, TruncatedEvent
from graphnav.core.record.sequence_gaps import numbered_fingerprints, seq_of
from graphnav.watch.loginfo.log_origin import LogOrigin, origin_of
from graphnav.watch.loginfo.unfinished import unfinished

_WALL_US = 1_000_000_000_000_000
"""Stamps from September 2001 on are wall time; simulated time begins at 0."""
_FINGERPRINT_BYTES = 8


@dataclass
class ChannelInfo:
    """The messages of one channel.

    ``type_name``: None if unknown; ``is_known``: whether its definition is installed; ``fingerprint``: the first 8
    bytes of a message in hex, None if it is shorter. ``first_us``, ``last_us``: microseconds since the first event.
    ``lost``: missing sequence numbers; ``n_restarts``: how often the numbering restarted; both None if messages
    have no numbers. ``undecodable``: messages that are damaged or not of the channel's type.
    """

    name: str
    type_name: str | None
    fingerprint: str | None
    first_us: int
    is_known: bool = False
    last_us: int = 0
    n_messages: int = 0
    n_bytes: int = 0
    min_bytes: int = 0
    max_bytes: int = 0
    undecodable: int = 0
    lost: int | None = None
    n_restarts: int | None = None

    @property
    def rate_hz(self) -> float | None:
        """Messages per second between the first and the last; None for a zero duration."""
        length_us = self.last_us - self.first_us
        return (self.n_messages - 1) / length_us * 1e6 if length_us else None


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
        surveys: dict[str, _Survey] = {}
        numbered = numbered_fingerprints()
        for event, at_us in zip(recording.events(), recording.timeline.at_us, strict=True):
            if event.channel not in surveys:
                surveys[event.channel] = _Survey(event.channel, event.data, at_us, numbered)
            surveys[event.channel].take(event.data, at_us)
        about = recording.about
        declared = dict(zip(about.channels, about.types, strict=False)) if about is not None else {}
        return LogInfo(
            path=path,
            n_bytes=recording.n_bytes,
            n_messages=recording.n_events,
            begin_us=recording.begin_us,
            duration_us=recording.timeline.duration_us,
            n_jumps=recording.timeline.n_jumps,
            channels=[surveys[name].finished(declared.get(name)) for name in sorted(surveys)],
            origin=origin_of(recording),
            completion_hint=recording.completion_hint,
            damaged=recording.damaged,
            truncated=recording.truncated,
            gaps=_gaps(recording),
            unfinished=unfinished(path),
        )


def _gaps(recording: Recording) -> tuple[tuple[int, Gap], ...]:
    try:
        found = [(utime, gap) for utime, _, gap in recording.messages(GAP) if isinstance(gap, Gap)]
    except LogError:
        return ()
    return tuple(found)


class _Survey:
    """The summary of one channel while its messages are read."""

    def __init__(self, name: str, data: bytes, at_us: int, numbered: frozenset[bytes]) -> None:
        self._info = ChannelInfo(name, None, None, at_us)
        self._numbered = numbered
        self._set_type(data)

    def take(self, data: bytes, at_us: int) -> None:
        """Count a message."""
        if self._codec is None and data[:_FINGERPRINT_BYTES] != self._fingerprint and type_of(data) is not None:
            self._set_type(data)
            self._info.undecodable = self._info.n_messages
        info, size = self._info, len(data)
        info.min_bytes = min(info.min_bytes, size) if info.n_messages else size
        info.max_bytes = max(info.max_bytes, size)
        info.n_messages += 1
        info.n_bytes += size
        info.last_us = at_us
        if not self._is_readable(data):
            info.undecodable += 1
        elif self._gaps is not None and (seq := seq_of(data)) is not None:
            self._gaps.see(seq)

    def finished(self, declared: str | None) -> ChannelInfo:
        """Return the summary; ``declared`` is the type named by the log itself."""
        info = self._info
        info.type_name = info.type_name or declared
        info.is_known = self._codec is not None
        if self._gaps is not None:
            info.lost, info.n_restarts = self._gaps.lost, max(0, self._gaps.n_restarts)
        return info

    def _set_type(self, data: bytes) -> None:
        self._fingerprint = data[:_FINGERPRINT_BYTES]
        lcm_class = type_of(data)
        self._codec: Codec | None = codec_of(lcm_class) if lcm_class is not None else None
        self._gaps = SequenceGaps() if self._fingerprint in self._numbered else None
        self._info.type_name = lcm_name(lcm_class) if lcm_class is not None else None
        is_complete = len(self._fingerprint) == _FINGERPRINT_BYTES
        self._info.fingerprint = self._fingerprint.hex() if is_complete else None

    def _is_readable(self, data: bytes) -> bool:
        if self._codec is None:
            return self._info.fingerprint is None or data[:_FINGERPRINT_BYTES] == self._fingerprint
        try:
            self._codec.decode(data)
        except DecodeError:
            return False
        return True
