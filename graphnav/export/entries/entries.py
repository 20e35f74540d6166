"""What viewers of runs take: pictures, scalars, the map, poses, the path, lines of text."""

from __future__ import annotations

import io
from dataclasses import dataclass
from enum import Enum
from typing import Any

from PIL import Image as PillowImage

from graphnav.arrays import Bytes, Doubles
from graphnav.messages import Map

_PNG_LEVEL = 3
"""Of zlib; 9 takes ten times as long for a few per cent."""


class Level(Enum):
    """How much a line of text matters."""

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
        """Return it as PNG."""
        file = io.BytesIO()
        PillowImage.fromarray(self.pixels).save(file, "PNG", compress_level=_PNG_LEVEL)
        return file.getvalue()


@dataclass(frozen=True)
class Scalars:
    """The LCM fields of a message, for those that are scalars."""

    channel: str
    utime: int
    lcm_class: type
    fields: dict[str, Any]


@dataclass(frozen=True)
class World:
    """The map, seen from above."""

    utime: int
    world: Map


@dataclass(frozen=True)
class Robot:
    """What the robot looks like: its radius, and the outline (n, 2) in R of what its camera sees of the floor."""

    utime: int
    radius_m: float
    footprint_m: Doubles


@dataclass(frozen=True)
class Pose:
    """Where the robot is: metres and radians, counterclockwise; poses of moving obstacles, (n, 3)."""

    utime: int
    x_m: float
    y_m: float
    yaw_rad: float
    moving: Doubles


@dataclass(frozen=True)
class Path:
    """Where the robot was so far: metres, (n, 2)."""

    utime: int
    points_m: Doubles


@dataclass(frozen=True)
class Line:
    """A line of text, and the channel or file that it comes from."""

    utime: int
    level: Level
    text: str
    source: str


Entry = Picture | Scalars | World | Robot | Pose | Path | Line
