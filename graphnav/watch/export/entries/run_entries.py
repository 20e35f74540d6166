"""Convert the selected messages of a run to entries in order of time."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from graphnav import Map, Odometry, Scan, Scene, State
from graphnav.core.pictures import Pictures
from graphnav.watch.export.entries.entries import Beams, Entry, Level, Line, Scalars, World
from graphnav.watch.export.entries.event_lines import Lines, heading, outcome_lines
from graphnav.watch.export.entries.message_entries import MessageEntries
from graphnav.watch.export.log_pass import LogPass
from graphnav.watch.export.reader import Reader, Sample

_MAX_PATHS = 200
"""The maximum number of path updates: one per pose would take quadratic space."""
MAX_UTIME = 2**32 * 1_000_000
"""The maximum timestamp with 32-bit seconds."""


class RunEntries:
    """Iterates over the entries of a run, once.

    ``unstamped``: number of messages left out because their timestamps are out of range for viewers, by channel.
    """

    def __init__(self, reader: Reader, pictures: Pictures) -> None:
        self.unstamped: Counter[str] = Counter()
        self.reader = reader
        self._walk = LogPass(reader)
        self._messages = MessageEntries(pictures, self._walk)
        self._lines = Lines()
        self._poses = 0

    def __iter__(self) -> Iterator[Entry]:
        first_us: int | None = None
        last_us = self.reader.recording.begin_us
        for sample in self._walk:
            if not 0 <= sample.utime < MAX_UTIME:
                self.unstamped[sample.channel] += 1
                continue
            if first_us is None:
                first_us = sample.utime
                yield from self._at_begin(first_us)
            last_us = sample.utime
            yield from self._entries(sample)
        if first_us is None:
            return
        yield from self._path(last_us)
        yield from outcome_lines(self.reader.recording, first_us, last_us)
        for text in self.losses():
            yield Line(last_us, Level.WARNING, text, self.reader.recording.path.name)

    def losses(self) -> list[str]:
        """Return one sentence per part of the selection that was not exported."""
        texts, undrawn = self.reader.losses(), self._messages.undrawn
        for name, count in self.unstamped.items():
            left_out = (
                "1 message is left out: its timestamp is"
                if count == 1
                else f"{count} messages are left out: timestamps are"
            )
            texts.append(f"channel {name!r}: {left_out} out of range")
        return texts + [f"channel {name!r}: pictures are missing: {why}" for name, why in undrawn.items()]

    def _at_begin(self, utime: int) -> Iterator[Entry]:
        text = heading(self.reader.recording.about)
        if text:
            yield Line(utime, Level.INFO, text, self.reader.recording.path.name)
        world = self._walk.first(Map)
        scene = None if world is None else Scene(world)
        if scene is not None and any(self.reader.message_type(name) is Map for name in self.reader.channels):
            yield World(utime, scene)
        if self._walk.pose_channel in self.reader.channels:
            yield self._messages.robot(utime, scene)

    def _entries(self, sample: Sample) -> Iterator[Entry]:
        message = self.reader.message(sample.channel, sample.fields)
        lcm_class = self.reader.recording.channels[sample.channel]
        assert lcm_class is not None
        yield Scalars(sample.channel, sample.utime, lcm_class, sample.fields)
        if message is None:
            return
        yield from self._lines.of(sample.channel, sample.utime, message)
        if sample.channel == self._walk.pose_channel and isinstance(message, State | Odometry):
            yield from self._pose(sample.utime, message)
        if isinstance(message, Scan):
            yield Beams(sample.channel, sample.utime, message)
        if (picture := self._messages.picture(sample.channel, sample.utime, message)) is not None:
            yield picture

    def _pose(self, utime: int, message: State | Odometry) -> Iterator[Entry]:
        if (pose := self._messages.pose(utime, message)) is None:
            return
        yield pose
        self._poses += 1
        every = max(1, self.reader.recording.count(self._walk.pose_channel or "") // _MAX_PATHS)
        if self._poses % every == 0:
            yield from self._path(utime)

    def _path(self, utime: int) -> Iterator[Entry]:
        if self._poses and (path := self._messages.path(utime)) is not None:
            yield path
