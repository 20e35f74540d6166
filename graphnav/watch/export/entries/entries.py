"""The types of entries: pictures, scans, scalars, the map, poses, the path, lines of text."""

from __future__ import annotations

import io
from dataclasses import dataclass
from enum import Enum
from typing import Any

from PIL import Image as PillowImage

from graphnav import Scan, Scene, SceneArea
from graphnav.arrays import Bytes, Doubles

_PNG_LEVEL = 3
"""The zlib level; 9 takes ten times as long and saves a few per cent."""


class Level(Enum):
    """The severity of a line of text."""

    INFO = "info"
    WARNING = "warning"
    ERROR = "error"


@dataclass(frozen=True)
class Picture:
    """The picture of a message: uint8 (rows, cols) gray, or (rows, cols, 3) red-green-blue."""

    channel: str
    utime: int
    pixels: Bytes

    def png(self) -> bytes:
        """Return the picture as PNG."""
        file = io.BytesIO()
        PillowImage.fromarray(self.pixels).save(file, "PNG", compress_level=_PNG_LEVEL)
        return file.getvalue()


@dataclass(frozen=True)
class Beams:
    """The scan of a lidar, in the robot's frame."""

    channel: str
    utime: int
    scan: Scan


@dataclass(frozen=True)
class Scalars:
    """The LCM fields of a message, of which the scalars are exported."""

    channel: str
    utime: int
    lcm_class: type
    fields: dict[str, Any]


@dataclass(frozen=True)
class World:
    """The map of the world."""

    utime: int
    scene: Scene


@dataclass(frozen=True)
class Robot:
    """The shape of the robot: its radius, and what its camera sees of the floor in R, None without a camera.

    ``body``: its outline in R, where it is not a disc.
    """

    utime: int
    radius_m: float
    seen: SceneArea | None
    body: SceneArea | None = None


@dataclass(frozen=True)
class Pose:
    """The pose of the robot: metres and radians, counterclockwise; poses of moving obstacles, (n, 3)."""

    utime: int
    x_m: float
    y_m: float
    yaw_rad: float
    moving: Doubles


@dataclass(frozen=True)
class Path:
    """The robot's path so far: metres, (n, 2)."""

    utime: int
    points_m: Doubles


@dataclass(frozen=True)
class Line:
    """A line of text, and its source: a channel or file."""

    utime: int
    level: Level
    text: str
    source: str


Entry = Picture | Beams | Scalars | World | Robot | Pose | Path | Line
