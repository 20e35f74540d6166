"""Read LCM logs: random access to every channel's messages after one scan of the file."""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple, Self, TypeVar

from graphnav.codec import DecodeError, codec_of, decode, message_class_of, type_named, type_of
from graphnav.errors import LogError, UserError, shown_name
from graphnav.messages import About, Message
from graphnav.record.event import Damaged, Entry, Event, LogFile, TruncatedEvent
from graphnav.record.index import Index
from graphnav.record.scan import scan
from graphnav.record.timeline import Timeline
from graphnav.run_folder import LOG
from graphnav.spec import parse_yaml

M = TypeVar("M", bound=Message)

ABOUT = "graphnav.about"
"""The channel of the first event, which describes the log."""

_FINGERPRINT_BYTES = 8
_HEAD = struct.Struct(">8sqq")


class Head(NamedTuple):
    """An event without its data: its header, and the fields with which every message type begins.

    ``place`` counts within the channel, ``logged_us`` is the event's timestamp, ``utime`` and ``seq`` are those of the
    message; ``fingerprint`` is empty if the data are too short for them.
    """

    channel: str
    place: int
    logged_us: int
    n_bytes: int
    fingerprint: bytes
    utime: int
    seq: int


class Recording:
    """A log of graphnav or of any other LCM program.

    ``channels`` maps each channel to its lcm-gen class, or to None if the type is not installed. ``truncated``:
    the incomplete last event, None if the log is complete; ``damaged``: the bytes between events that were skipped.

    Raises LogError if the file cannot be read or is not a log.
    """

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        self.truncated: TruncatedEvent | None = None
        self.damaged: list[Damaged] = []
        self._file = LogFile(self.path)
        self._index = Index()
        for entry in scan(self.path, self._file):
            if isinstance(entry, TruncatedEvent):
                self.truncated = entry
            elif isinstance(entry, Damaged):
                self.damaged.append(entry)
            else:
                self._index.add(entry)

    @cached_property
    def about(self) -> About | None:
        """The description of the run: the first event of ``graphnav.about`` at any position, None without one."""
        if not self.count(ABOUT):
            return None
        try:
            return self._decoded(ABOUT, 0, About)[2]
        except LogError:
            return None

    @cached_property
    def graph(self) -> dict[str, Any]:
        """The resolved graph that produced the log; raises LogError if the log does not hold it."""
        if self.about is None:
            raise LogError(f"{self.path} does not hold the graph that produced it: no readable event on '{ABOUT}'")
        try:
            graph = parse_yaml(self.about.graph_yaml.encode(), str(self.path))[0].plain()
        except UserError:
            graph = None
        if not isinstance(graph, dict):
            raise LogError(f"{self.path}: its '{ABOUT}' holds no graph")
        return graph

    @cached_property
    def channels(self) -> Mapping[str, type | None]:
        """The type of each channel, in the order of their first events."""
        declared = dict(zip(self.about.channels, self.about.types, strict=False)) if self.about else {}
        return {
            channel: (type_named(declared[channel]) if channel in declared else None)
            or type_of(self.event(channel, 0).data)
            for channel in self._index.channels
        }

    @property
    def completion_hint(self) -> str:
        """How to make again what the log leaves out, which ``record: replayable`` allows; else an empty string."""
        try:
            options = self.graph.get("run")
        except LogError:
            return ""
        is_of_tap = self.about is not None and bool(self.about.run_id)  # which sends everything
        if is_of_tap or not isinstance(options, dict) or options.get("record") != "replayable":
            return ""
        log = self.path.parent if self.path.name == LOG else self.path
        return f"make the rest again: graphnav replay {shown_name(str(log))} -o full.lcmlog"

    def completion_notice(self) -> str:
        """Return a notice of what the log leaves out, as `completion_hint`; else an empty string."""
        hint = self.completion_hint
        return f"{self.path} leaves out large messages that a replay makes again\n  {hint}" if hint else ""

    @property
    def begin_us(self) -> int:
        """The timestamp of the first event, microseconds: 0 in lockstep, wall time live; 0 for an empty log."""
        return self._index[0].utime if len(self._index) else 0

    @property
    def n_events(self) -> int:
        """The number of events on all channels."""
        return len(self._index)

    @property
    def n_bytes(self) -> int:
        """The size of the file."""
        return self._file.size

    @cached_property
    def timeline(self) -> Timeline:
        """The time of each event since the first one."""
        return Timeline([entry.utime for entry in self.entries()])

    def damage_notice(self) -> str:
        """Return a warning for a damaged log, an empty string for a complete one."""
        lost: list[Damaged | TruncatedEvent] = [
            *self.damaged,
            *([self.truncated] if self.truncated is not None else []),
        ]
        if not lost:
            return ""
        what = str(lost[0]) if len(lost) == 1 else f"{sum(one.n_bytes for one in lost)} bytes in {len(lost)} places"
        return f"{self.path} is damaged: {what}\n  'graphnav info' tells more"

    def entries(self) -> Iterator[Entry]:
        """Yield the position of each event's data in file order, without reading the data."""
        return (self._index[number] for number in range(len(self._index)))

    def at(self, number: int) -> Event:
        """Return one event by its index in the file, counted over all channels."""
        return self._event(self._index[number])

    @property
    def index(self) -> Index:
        """The positions of all events, in file order and by channel."""
        return self._index

    def count(self, channel: str) -> int:
        """Return the number of events on a channel; 0 if there is no such channel."""
        return len(self._index.channels.get(channel, ()))

    def utimes(self, channel: str) -> list[int]:
        """Return the timestamps of a channel's messages, microseconds.

        In a log of graphnav they equal those of its events. A logger stamps events with wall time instead; the first
        field of every graphnav message type is the message's own timestamp.
        """
        entries = [self._index[number] for number in self._index.channels.get(channel, ())]
        if not entries or (lcm_class := self.channels[channel]) is None or message_class_of(lcm_class) is None:
            return [entry.utime for entry in entries]
        if self._stamp(entries[0]) == entries[0].utime:
            return [entry.utime for entry in entries]
        return [self._stamp(entry) for entry in entries]

    def event_utimes(self, channel: str) -> list[int]:
        """Return the timestamps of a channel's events, microseconds: simulated time, or when they were logged."""
        return [self._index[number].utime for number in self._index.channels.get(channel, ())]

    def events(self) -> Iterator[Event]:
        """Yield all events in file order."""
        return map(self._event, self.entries())

    def heads(self) -> Iterator[Head]:
        """Yield the heads of all events in file order, without reading the rest of their data."""
        counts: Counter[str] = Counter()
        for number in range(len(self._index)):
            entry = self._index[number]
            yield self._head(entry, counts[entry.channel])
            counts[entry.channel] += 1

    def event(self, channel: str, index: int) -> Event:
        """Return one event; ``index`` counts within the channel, from the end if negative."""
        return self._event(self._index.of(channel, index))

    def message(self, channel: str, index: int) -> tuple[int, int, Message]:
        """Return ``(utime, seq, message)`` of one event; raises LogError if it cannot be decoded."""
        lcm_class = self.channels[channel]
        wrapper = lcm_class and message_class_of(lcm_class)
        if wrapper is None:
            raise LogError(f"{self.path}: the type of channel '{channel}' is not installed")
        return self._decoded(channel, index, wrapper)

    def messages(self, channel: str) -> Iterator[tuple[int, int, Message]]:
        """Yield ``(utime, seq, message)`` of a channel's events; none if there is no such channel."""
        return (self.message(channel, index) for index in range(self.count(channel)))

    def fields(self, channel: str, index: int) -> dict[str, Any]:
        """Return all LCM fields of one event, including types without a message class."""
        lcm_class = self.channels[channel]
        if lcm_class is None:
            raise LogError(f"{self.path}: the type of channel '{channel}' is not installed")
        try:
            return codec_of(lcm_class).decode(self.event(channel, index).data)
        except DecodeError as error:
            raise LogError(f"{self.path}: event {index} of channel '{channel}': {error}") from error

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _stamp(self, entry: Entry) -> int:
        begin = entry.start + _FINGERPRINT_BYTES
        return int.from_bytes(self._file.read(begin, min(begin + 8, entry.stop)), "big", signed=True)

    def _head(self, entry: Entry, place: int) -> Head:
        data = self._file.read(entry.start, min(entry.start + _HEAD.size, entry.stop))
        first = _HEAD.unpack(data) if len(data) == _HEAD.size else (b"", 0, 0)
        return Head(entry.channel, place, entry.utime, entry.stop - entry.start, *first)

    def _event(self, entry: Entry) -> Event:
        return Event(entry.channel, entry.utime, self._file.read(entry.start, entry.stop))

    def _decoded(self, channel: str, index: int, wrapper: type[M]) -> tuple[int, int, M]:
        try:
            return decode(wrapper, self.event(channel, index).data)
        except DecodeError as error:
            raise LogError(f"{self.path}: event {index} of channel '{channel}': {error}") from error
