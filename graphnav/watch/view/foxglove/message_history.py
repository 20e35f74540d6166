"""Past messages for pictures and the path, decoded on demand."""

from __future__ import annotations

from typing import TypeVar, cast

import numpy as np

from graphnav import Message, Odometry, State
from graphnav.arrays import Doubles
from graphnav.core.codec import DecodeError, codec_of
from graphnav.watch.export.log_pass import POSES
from graphnav.watch.export.reader import MessageTypes
from graphnav.watch.view.foxglove.arrivals import Arrival

M = TypeVar("M", bound=Message)

_MAX_POSES = 4000
_MAX_POSE_BYTES = 1 << 16


class MessageHistory:
    """The newest message of each type, and the poses; of several channels of one type the first one is used."""

    def __init__(self, types: MessageTypes) -> None:
        self._types = types
        self.forget()

    def forget(self) -> None:
        """Clear the history, for another run or another time of a log."""
        self.pose_channel: str | None = None
        self._pose_type: type[Message] | None = None
        self._newest: dict[type[Message], tuple[Arrival, type]] = {}
        self._decoded: dict[type[Message], tuple[Arrival, Message | None]] = {}
        self._path: list[tuple[float, float]] = []
        self._waiting: list[tuple[Arrival, type]] = []
        self._kept_every = 1
        self._since_kept = 0

    def receive(self, arrival: Arrival, lcm_class: type, message_type: type[Message]) -> None:
        """Store a message."""
        known = self._newest.get(message_type)
        if known is None or known[0].channel == arrival.channel:
            self._newest[message_type] = arrival, lcm_class
        if message_type in POSES:
            self._receive_pose(arrival, lcm_class, message_type)

    def channel_of(self, kind: type[Message]) -> str | None:
        """Return the channel whose messages are used for a type."""
        known = self._newest.get(kind)
        return None if known is None else known[0].channel

    def find(self, kind: type[M], /) -> M | None:
        """Return the newest message of ``kind``; None if there is none."""
        newest = self._newest.get(kind)
        if newest is None:
            return None
        if kind not in self._decoded or self._decoded[kind][0] is not newest[0]:
            self._decoded[kind] = newest[0], self._message(*newest)
        return cast("M | None", self._decoded[kind][1])

    def path_m(self) -> Doubles:
        """Return the robot's path so far, (n, 2), x_m and y_m; non-finite poses are left out."""
        for arrival, lcm_class in self._waiting:
            pose = self._message(arrival, lcm_class)
            if isinstance(pose, State | Odometry) and np.isfinite((pose.x_m, pose.y_m)).all():
                self._path.append((pose.x_m, pose.y_m))
        self._waiting.clear()
        return np.array(self._path, np.float64).reshape(-1, 2)

    def _receive_pose(self, arrival: Arrival, lcm_class: type, message_type: type[Message]) -> None:
        if self._pose_type is None or POSES.index(message_type) < POSES.index(self._pose_type):
            self.pose_channel, self._pose_type = arrival.channel, message_type
            self._path, self._waiting = [], []
        self._since_kept += 1
        if arrival.channel != self.pose_channel or self._since_kept < self._kept_every:
            return
        if len(arrival.data) > _MAX_POSE_BYTES:
            return
        self._since_kept = 0
        self._waiting.append((arrival, lcm_class))
        if len(self._path) + len(self._waiting) > _MAX_POSES:
            self._path, self._waiting = self._path[::2], self._waiting[::2]
            self._kept_every *= 2

    def _message(self, arrival: Arrival, lcm_class: type) -> Message | None:
        try:
            return self._types.message(lcm_class, codec_of(lcm_class).decode(arrival.data))
        except DecodeError:
            return None
