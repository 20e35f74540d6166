"""Read LCM logs: random access to every channel's messages after one scan of the file."""

from __future__ import annotations

import struct
from bisect import bisect_right
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple, Self, TypeVar

from graphnav.core.codec import (
    DecodeError,
    add_given_types,
    codec_of,
    decode,
    fields_of,
    message_class_of,
    type_named,
    type_of,
)
from graphnav.core.errors import LogError, UserError, shown_name
from graphnav.core.messages import About, Message
from graphnav.core.record.bags import BAG_SUFFIXES, Bag, is_bag
from graphnav.core.record.event import Damaged, Entry, Event, LogFile, TruncatedEvent
from graphnav.core.record.index import Index, Timeline
from graphnav.core.record.log_paths import parts_of
from graphnav.core.record.scan import scan
from graphnav.core.run_folder import RunFolder
from graphnav.core.spec import option_in, parse_yaml

M = TypeVar("M", bound=Message)

_RESERVED = "graphnav."
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
    """A log of graphnav or of any other LCM program, or a ROS 2 bag, whose topics are read as channels.

    ``channels`` maps each channel to its lcm-gen class, or to None if the type is not installed. Of a bag ``bag`` tells
    the ROS types; elsewhere it is None. ``truncated``:
    the incomplete last event, None if the log is complete; ``damaged``: the bytes between events that were skipped.
    ``content``: the file to read in place of ``path``, by its path or descriptor: the same log with what it leaves out.

    Raises LogError if the file cannot be read or is not a log, UserError if reading a bag needs an extra.
    """

    SMALL_BYTES = 4096
    """Messages below this are kept by every log, whatever it leaves out."""

    def __init__(self, path: Path | str, content: Path | int | None = None) -> None:
        self.path = Path(path)
        self.is_completed = content is not None
        """Whether what ``path`` leaves out was made again."""
        self.truncated: TruncatedEvent | None = None
        self.damaged: list[Damaged] = []
        self._index = Index()
        self._files: list[LogFile | Bag] = []
        self._begins: list[int] = []
        """Where each file begins in all their bytes."""
        self._n_bytes = 0
        self.bag: Bag | None = None
        if content is None and is_bag(self.path):
            self._add_bag(Bag(self.path))
            return
        for part in parts_of(self.path) if content is None else [content]:
            self._add(LogFile(part), is_first=not self._files)
        if None in self.channels.values() and (texts := {about.lcm_text: None for about in self._abouts()}):
            for text in texts:
                add_given_types(text)
            del self.channels

    def _add(self, file: LogFile, *, is_first: bool) -> None:
        """Add the events of a file; those after the first begin with a copy of the description, which is left out."""
        begin = self._n_bytes
        self._files.append(file)
        self._begins.append(begin)
        self._n_bytes += file.size
        if self.truncated is not None:
            self.damaged.append(Damaged(*self.truncated))
            self.truncated = None
        is_copy = not is_first
        for entry in scan(self.path, file):
            if isinstance(entry, TruncatedEvent):
                self.truncated = TruncatedEvent(begin + entry.at, entry.n_bytes)
            elif isinstance(entry, Damaged):
                self.damaged.append(Damaged(begin + entry.at, entry.n_bytes))
            else:
                if not is_copy or entry.channel != About.CHANNEL:
                    self._index.add(entry._replace(start=begin + entry.start, stop=begin + entry.stop))
                is_copy = False

    def _add_bag(self, bag: Bag) -> None:
        self.bag = bag
        self._files.append(bag)
        self._begins.append(0)
        self._n_bytes = bag.size
        try:
            for entry in bag.entries():
                self._index.add(entry)
        except BaseException:
            bag.close()
            raise

    def _read(self, start: int, stop: int) -> bytes:
        """Return bytes of one file, whose positions count in all files."""
        number = bisect_right(self._begins, start) - 1
        begin = self._begins[number]
        return self._files[number].read(start - begin, stop - begin)

    @staticmethod
    def is_log(path: Path) -> bool:
        """Whether a path is that of a log by its name (``.lcmlog``), or of a ROS 2 bag."""
        return path.suffix in (".lcmlog", *BAG_SUFFIXES) or is_bag(path)

    @cached_property
    def about(self) -> About | None:
        """The description of the run: the first one at any position that tells of more than types, None without one."""
        return next((about for about in self._abouts() if about.graph_yaml or about.channels), None)

    def _abouts(self) -> Iterator[About]:
        """Yield what ``graphnav.about`` says; what cannot be read is left out."""
        for index in range(self.count(About.CHANNEL)):
            with suppress(LogError):
                yield self._decoded(About.CHANNEL, index, About)[2]

    @cached_property
    def graph(self) -> dict[str, Any]:
        """The resolved graph that produced the log; raises LogError if the log does not hold it."""
        if self.about is None:
            raise LogError(
                f"{self.path} does not hold the graph that produced it: no readable event on '{About.CHANNEL}'"
            )
        try:
            graph = parse_yaml(self.about.graph_yaml.encode(), str(self.path))[0].plain()
        except UserError:
            graph = None
        if not isinstance(graph, dict):
            raise LogError(f"{self.path}: its '{About.CHANNEL}' holds no graph")
        return graph

    @cached_property
    def channels(self) -> Mapping[str, type | None]:
        """The type of each channel, in the order of their first events."""
        if self.bag is not None:
            return {topic: self.bag.lcm_class(topic) for topic in self._index.channels}
        declared = dict(zip(self.about.channels, self.about.types, strict=False)) if self.about else {}
        return {
            channel: (type_named(declared[channel]) if channel in declared else None)
            or type_of(self.event(channel, 0).data)
            for channel in self._index.channels
        }

    @property
    def foreign_types(self) -> Mapping[str, str]:
        """The ROS types of the topics of a bag that graphnav has no type for, by topic; none of a log."""
        types = {} if self.bag is None else self.bag.types
        return {topic: types[topic] for topic, lcm_class in self.channels.items() if topic in types and not lcm_class}

    @property
    def leaves_out(self) -> bool:
        """Whether large messages are left out that a replay makes again, as ``record: replayable`` allows."""
        try:
            options = self.graph.get("run")
        except LogError:
            return False
        is_of_tap = self.about is not None and bool(self.about.run_id)  # which sends everything
        if self.is_completed or is_of_tap or not isinstance(options, dict):
            return False
        return option_in(options.get("record")) == "replayable"

    @property
    def completion_hint(self) -> str:
        """How to write the log with what it leaves out; an empty string if it `leaves_out` nothing."""
        log = self.path.parent if self.path.name == RunFolder.LOG else self.path
        return (
            f"write the complete log: graphnav replay {shown_name(str(log))} -o full.lcmlog" if self.leaves_out else ""
        )

    def lacks(self, channel: str) -> bool:
        """Whether messages of a channel may be left out; false only where that is certain.

        Of what can be made again a log keeps every message below 4 kB, and the first of any size.
        """
        if not self.leaves_out or channel.startswith(_RESERVED):
            return False
        numbers = self._index.channels.get(channel, ())
        sizes = (self._index[number] for number in numbers)
        n_large = sum(entry.stop - entry.start >= Recording.SMALL_BYTES for entry in sizes)
        lcm_class = self.channels.get(channel)
        is_small = not n_large and lcm_class is not None and _has_fixed_size(lcm_class)
        return n_large < 2 and not is_small  # a second large one is kept only where all are

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
        """The size of its files."""
        return self._n_bytes

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
        """Return the number of events on a channel; 0 if the log does not have it."""
        return len(self._index.channels.get(channel, ()))

    def utimes(self, channel: str) -> list[int]:
        """Return the timestamps of a channel's messages, microseconds.

        In a log of graphnav they equal those of its events. A logger stamps events with wall time instead; the first
        field of every graphnav message type is the message's own timestamp.
        """
        entries = [self._index[number] for number in self._index.channels.get(channel, ())]
        if not entries or (lcm_class := self.channels[channel]) is None or message_class_of(lcm_class) is None:
            return [entry.utime for entry in entries]
        if self.bag is None and self._stamp(entries[0]) == entries[0].utime:
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
        """Yield ``(utime, seq, message)`` of a channel's events; none if the log does not have it."""
        return (self.message(channel, index) for index in range(self.count(channel)))

    def fields(self, channel: str, index: int) -> dict[str, Any]:
        """Return all LCM fields of one event, including types without a message class."""
        lcm_class = self.channels[channel]
        if lcm_class is None:
            raise LogError(f"{self.path}: the type of channel '{channel}' is not installed")
        try:
            return codec_of(lcm_class).decode(self.event(channel, index).data)
        except DecodeError as error:
            raise self._undecodable(channel, index, error) from error

    def close(self) -> None:
        """Close the files."""
        for file in self._files:
            file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _stamp(self, entry: Entry) -> int:
        begin = entry.start + _FINGERPRINT_BYTES
        return int.from_bytes(self._read(begin, min(begin + 8, entry.stop)), "big", signed=True)

    def _head(self, entry: Entry, place: int) -> Head:
        data = self._read(entry.start, min(entry.start + _HEAD.size, entry.stop))
        first = _HEAD.unpack(data) if len(data) == _HEAD.size else (b"", 0, 0)
        return Head(entry.channel, place, entry.utime, entry.stop - entry.start, *first)

    def _event(self, entry: Entry) -> Event:
        return Event(entry.channel, entry.utime, self._read(entry.start, entry.stop))

    def _decoded(self, channel: str, index: int, wrapper: type[M]) -> tuple[int, int, M]:
        try:
            return decode(wrapper, self.event(channel, index).data)
        except DecodeError as error:
            raise self._undecodable(channel, index, error) from error

    def _undecodable(self, channel: str, index: int, error: DecodeError) -> LogError:
        """Return the error of an event that is not of its channel's type."""
        if self.bag is None:
            return LogError(f"{self.path}: event {index} of channel '{channel}': {error}")
        why = self.bag.fault(self._index.of(channel, index).start) or error
        return LogError(f"{self.path}: message {index} of topic '{channel}': {why}")


def _has_fixed_size(lcm_class: type) -> bool:
    """Whether every message of a type has the same size."""
    return all(
        field.primitive != "string"
        and all(isinstance(dim, int) for dim in field.dims)
        and (field.struct is None or _has_fixed_size(field.struct))
        for field in fields_of(lcm_class)
    )
