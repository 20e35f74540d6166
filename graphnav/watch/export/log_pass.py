"""One pass through a log in file order, which keeps the past messages that pictures need."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, TypeVar, cast

import numpy as np

from graphnav import Message, Odometry, PictureContext, State
from graphnav.arrays import Doubles
from graphnav.core.codec import DecodeError, codec_of
from graphnav.core.record import Event
from graphnav.watch.export.reader import Reader, Sample

M = TypeVar("M", bound=Message)

POSES: tuple[type[Message], ...] = (State, Odometry)
"""The types of pose messages, preferred first: states, odometry."""


class LogPass:
    """Yields the selected messages, oldest first; ``find`` and ``path_m`` refer to the last yielded message.

    They use all channels, selected or not: a plane is drawn over its image even if only planes are exported. Of
    several channels of one type, the first in the log is used.
    """

    def __init__(self, reader: Reader) -> None:
        self._reader = reader
        self._kinds: dict[str, type[Message]] = {}
        for name in reader.recording.channels:
            kind = reader.message_type(name)
            if kind is not None and kind not in self._kinds.values():
                self._kinds[name] = kind
        poses = (self._channel_of(kind) for kind in POSES)
        self.pose_channel = next((channel for channel in poses if channel is not None), None)
        self._newest: dict[type[Message], Event] = {}
        self._now = 0
        self._decoded: dict[type[Message], tuple[Event, Message | None]] = {}
        self._waiting: list[Event] = []
        self._path: list[tuple[float, float]] = []

    def __iter__(self) -> Iterator[Sample]:
        for event in self._reader.recording.events():
            kind = self._kinds.get(event.channel)
            if kind is not None:
                self._newest[kind] = event
            if event.channel == self.pose_channel:
                self._waiting.append(event)
            self._now = event.utime
            if self._reader.holds(event) and (sample := self._reader.decoded(event)) is not None:
                yield sample

    def find(self, kind: type[M], /) -> M | None:
        """Return the newest message of ``kind``, else the first if it has the same timestamp; None if there is none.

        Within one timestamp, a map may follow the first state.
        """
        event = self._newest.get(kind) or self._first_event(kind)
        if event is None or event.utime > self._now:
            return None
        if kind not in self._decoded or self._decoded[kind][0] is not event:
            self._decoded[kind] = event, self._message(event)
        return cast("M | None", self._decoded[kind][1])

    def path_m(self) -> Doubles:
        """Return the robot's path so far, (n, 2), x_m and y_m; non-finite poses are left out."""
        for event in self._waiting:
            pose = self._message(event)
            if isinstance(pose, State | Odometry) and np.isfinite((pose.x_m, pose.y_m)).all():
                self._path.append((pose.x_m, pose.y_m))
        self._waiting.clear()
        return np.array(self._path, np.float64).reshape(-1, 2)

    def context(self, rows: int, cols: int, *, with_legend: bool) -> PictureContext:
        """Return the context for a picture of the last yielded message."""
        return PictureContext(rows, cols, self.find, self.path_m, with_legend)

    def first(self, kind: type[M]) -> M | None:
        """Return the first message of ``kind`` in the log, selected or not."""
        event = self._first_event(kind)
        return None if event is None else cast("M | None", self._message(event))

    def _first_event(self, kind: type[Message]) -> Event | None:
        channel = self._channel_of(kind)
        return None if channel is None else self._reader.recording.event(channel, 0)

    def _channel_of(self, kind: type[Message]) -> str | None:
        return next((name for name, found in self._kinds.items() if found is kind), None)

    def _message(self, event: Event) -> Message | None:
        lcm_class: Any = self._reader.recording.channels[event.channel]
        try:
            return self._reader.message(event.channel, codec_of(lcm_class).decode(event.data))
        except DecodeError:
            return None
