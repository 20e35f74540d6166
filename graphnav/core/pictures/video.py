"""The frames of a video, drawn on demand."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from graphnav.arrays import Bytes


class VideoFrames(NamedTuple):
    """``n_frames`` frames at ``rate_hz``: the timestamp (microseconds) of each, and uint8 (rows, cols, 3) RGB.

    All frames have the same shape, with even numbers of rows and columns.
    """

    rate_hz: float
    n_frames: int
    frames: Iterator[tuple[int, Bytes]]
