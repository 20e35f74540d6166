"""The arguments and results of hooks that draw: the context of a picture of one message, and the frames of a video."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple, Protocol, TypeVar

import numpy as np

from graphnav.arrays import Bytes, Doubles
from graphnav.core.messages import Message

M = TypeVar("M", bound=Message)


class Find(Protocol):
    """Finds the message of another type that belongs to the drawn message."""

    def __call__(self, kind: type[M], /) -> M | None:
        """Return the message of ``kind`` with the same timestamp, else the newest before it; None if there is none."""


def no_message(_kind: type[M], /) -> M | None:
    """Return None: only the drawn message itself is available."""
    return None


def no_path() -> Doubles:
    """Return a path without points."""
    return np.empty((0, 2))


@dataclass(frozen=True)
class PictureContext:
    """The arguments of ``graphnav_picture`` in addition to the message.

    ``rows``, ``cols``: the maximum size of the picture, pixels. ``find``: returns other messages of the same time, such
    as the image below a plane or the map around a state, decoded on demand. ``path_m``: returns the robot's path so
    far, float64 (n, 2), x_m and y_m in W, oldest first. ``with_legend``: whether to draw text, scale bars and colour
    wheels. ``with_colour``: whether colours can be displayed; otherwise only brightness is visible.
    """

    rows: int = 480
    cols: int = 640
    find: Find = no_message
    path_m: Callable[[], Doubles] = no_path
    with_legend: bool = True
    with_colour: bool = True


class VideoFrames(NamedTuple):
    """``n_frames`` frames at ``rate_hz``: the timestamp (microseconds) of each, and uint8 (rows, cols, 3) RGB.

    All frames have the same shape, with even numbers of rows and columns.
    """

    rate_hz: float
    n_frames: int
    frames: Iterator[tuple[int, Bytes]]
