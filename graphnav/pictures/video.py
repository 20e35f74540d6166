"""The frames of a video, drawn when they are asked for."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from graphnav.arrays import Bytes


class VideoFrames(NamedTuple):
    """``n_frames`` frames for ``rate_hz``: the stamp (microseconds) of each, and uint8 (rows, cols, 3) RGB.

    All have the same shape, whose rows and columns are even.
    """

    rate_hz: float
    n_frames: int
    frames: Iterator[tuple[int, Bytes]]
