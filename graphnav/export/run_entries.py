"""A run as viewers take it: entries in the order of time, made of the selected messages."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np

from graphnav.errors import DrawingError
from graphnav.export.entries import Entry, Level, Line, Path, Picture, Pose, Robot, Scalars, World
from graphnav.export.lines import Lines, heading, outcome_lines
from graphnav.export.reader import Reader, Sample
from graphnav.export.walk import Walk
from graphnav.messages import Image, Map, Message, Odometry, State
from graphnav.pictures import Pictures

_MAX_PATHS = 200
"""So often the path so far is told anew: every time would take the square of the run's length."""
_MAX_PATH_POINTS = 1000
_MAX_SIDE_PX = 1280
_RADIUS_M, _MAX_RADIUS_M = 0.2, 100.0
"""Of a robot whose log has no map that tells it; what is more than the second is not a radius."""
_MAX_UTIME = 2**32 * 1_000_000
"""What a timestamp of 32-bit seconds holds."""


class RunEntries:
    """Iterates over the entries of a run, once.

    ``undrawn``: why the last picture of a channel that could not be drawn was not, by channel. ``unstamped``: messages
    whose stamps no viewer can show, by channel; they are left out.
    """

    def __init__(self, reader: Reader, pictures: Pictures) -> None:
        self.undrawn: dict[str, str] = {}
        self.unstamped: Counter[str] = Counter()
        self.reader = reader
        self._walk = Walk(reader)
        self._pictures = pictures
        self._lines = Lines()
        self._without_pictures: set[str] = set()
        self._poses = 0

    def __iter__(self) -> Iterator[Entry]:
        first_us: int | None = None
        last_us = self.reader.recording.begin_us
        for sample in self._walk:
            if not 0 <= sample.utime < _MAX_UTIME:
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
        """Return what of the selection was not exported, one sentence each."""
        texts = self.reader.losses()
        for name, count in self.unstamped.items():
            said = "1 message is left out: its stamp is" if count == 1 else f"{count} messages are left out: stamps are"
            texts.append(f"channel {name!r}: {said} out of range")
        return texts + [f"channel {name!r}: pictures are missing: {why}" for name, why in self.undrawn.items()]

    def _at_begin(self, utime: int) -> Iterator[Entry]:
        text = heading(self.reader.recording)
        if text:
            yield Line(utime, Level.INFO, text, self.reader.recording.path.name)
        world = self._walk.first(Map)
        if world is not None and any(self.reader.message_type(name) is Map for name in self.reader.channels):
            yield World(utime, world)
        if self._walk.pose_channel in self.reader.channels:
            radius_m = world.robot_radius_m if world is not None else _RADIUS_M
            footprint_m = world.footprint_m if world is not None else np.empty((0, 2))
            yield Robot(utime, radius_m if 0 < radius_m < _MAX_RADIUS_M else _RADIUS_M, footprint_m)

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
        picture = self._picture(sample, message)
        if picture is not None:
            yield picture

    def _pose(self, utime: int, message: State | Odometry) -> Iterator[Entry]:
        if not np.isfinite((message.x_m, message.y_m, message.yaw_rad)).all():
            return
        moving = message.moving if isinstance(message, State) else np.empty((0, 3))
        yield Pose(utime, message.x_m, message.y_m, message.yaw_rad, moving)
        self._poses += 1
        every = max(1, self.reader.recording.count(self._walk.pose_channel or "") // _MAX_PATHS)
        if self._poses % every == 0:
            yield from self._path(utime)

    def _path(self, utime: int) -> Iterator[Entry]:
        points = self._walk.path_m()
        if self._poses and len(points) > 1:
            picked = np.linspace(0, len(points) - 1, min(len(points), _MAX_PATH_POINTS)).astype(int)
            yield Path(utime, points[picked])

    def _picture(self, sample: Sample, message: Message) -> Picture | None:
        """Return the picture of a message that has rows and columns: an image as it is, others drawn by plugins."""
        if isinstance(message, Image):
            return Picture(sample.channel, sample.utime, np.ascontiguousarray(message.pixels))
        if not message.grid or sample.channel in self._without_pictures:
            return None
        rows, cols = getattr(message, message.grid[0]).shape[:2]
        step = getattr(message, "step_px", 1)
        scale = min(1.0, _MAX_SIDE_PX / max(rows * step, cols * step, 1))
        context = self._walk.context(
            max(1, round(rows * step * scale)), max(1, round(cols * step * scale)), with_legend=False
        )
        try:
            pixels = self._pictures.draw(message, context)
        except DrawingError as error:
            self.undrawn[sample.channel] = str(error)
            return None
        if pixels is None:
            self._without_pictures.add(sample.channel)
            return None
        return Picture(sample.channel, sample.utime, pixels)
