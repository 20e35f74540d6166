"""Make the entries of one message: its picture, the robot's pose, the path so far."""

from __future__ import annotations

from typing import Protocol, TypeVar

import numpy as np

from graphnav import Image, Message, Odometry, PictureContext, Scene, State
from graphnav.arrays import Doubles
from graphnav.core.errors import DrawingError
from graphnav.core.pictures import Pictures
from graphnav.watch.export.entries.entries import Path, Picture, Pose, Robot

M = TypeVar("M", bound=Message)

_MAX_PATH_POINTS = 1000
_MAX_SIDE_PX = 1280
_RADIUS_M, _MAX_RADIUS_M = 0.2, 100.0
"""The radius of a robot without a map in the log, and the maximum plausible radius."""


class Past(Protocol):
    """The messages before the current one."""

    def find(self, kind: type[M], /) -> M | None:
        """Return the message of ``kind`` with the same timestamp, else the newest before it; None if there is none."""

    def path_m(self) -> Doubles:
        """Return the robot's path so far, (n, 2), x_m and y_m."""


def may_have_picture(message_type: type[Message] | None) -> bool:
    """Whether messages of a type are shown as pictures: those with rows and columns."""
    return message_type is not None and (issubclass(message_type, Image) or bool(message_type.grid))


class MessageEntries:
    """Makes entries of messages; ``undrawn``: the last drawing error by channel."""

    def __init__(self, pictures: Pictures, past: Past) -> None:
        self.undrawn: dict[str, str] = {}
        self._pictures, self._past = pictures, past

    def picture(self, channel: str, utime: int, message: Message) -> Picture | None:
        """Return the picture of a message with rows and columns: an image unchanged, others drawn by plugins."""
        if isinstance(message, Image):
            return Picture(channel, utime, np.ascontiguousarray(message.pixels))
        if not message.grid:
            return None
        rows, cols = getattr(message, message.grid[0]).shape[:2]
        step = getattr(message, "step_px", 1)
        scale = min(1.0, _MAX_SIDE_PX / max(rows * step, cols * step, 1))
        sides = (max(1, round(rows * step * scale)), max(1, round(cols * step * scale)))
        context = PictureContext(*sides, self._past.find, self._past.path_m, with_legend=False)
        try:
            pixels = self._pictures.draw(message, context)
        except DrawingError as error:
            self.undrawn[channel] = str(error)
            return None
        return None if pixels is None else Picture(channel, utime, pixels)

    def pose(self, utime: int, message: State | Odometry) -> Pose | None:
        """Return the pose of the robot, None if it is not finite."""
        if not np.isfinite((message.x_m, message.y_m, message.yaw_rad)).all():
            return None
        moving = message.moving if isinstance(message, State) else np.empty((0, 3))
        return Pose(utime, message.x_m, message.y_m, message.yaw_rad, moving)

    def path(self, utime: int) -> Path | None:
        """Return the path so far, None for a single point."""
        points = self._past.path_m()
        if len(points) < 2:
            return None
        picked = np.linspace(0, len(points) - 1, min(len(points), _MAX_PATH_POINTS)).astype(int)
        return Path(utime, points[picked])

    def robot(self, utime: int, scene: Scene | None) -> Robot:
        """Return the shape of the robot, from the map."""
        radius_m = scene.robot_radius_m if scene is not None else _RADIUS_M
        seen = scene.seen if scene is not None else None
        if not 0 < radius_m < _MAX_RADIUS_M:
            return Robot(utime, _RADIUS_M, seen)
        return Robot(utime, radius_m, seen, None if scene is None else scene.robot)
