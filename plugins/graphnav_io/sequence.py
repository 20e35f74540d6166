"""Open recorded pictures or a video together with their times."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from graphnav import ParamError
from graphnav.arrays import Longs
from graphnav_io.capture import open_capture
from graphnav_io.frames import Frames
from graphnav_io.picture_times import picture_times, row_times
from graphnav_io.pictures import PictureFrames, find_pictures, is_pictures

ONE_PICTURE_HZ = 10.0
"""The rate of a sequence of one picture."""


class Sequence(NamedTuple):
    """Frames and their times."""

    frames: Frames
    timeline: Timeline


def open_sequence(path: Path, times: Path | None, rate_hz: float, start_s: float) -> Sequence:
    """Open a folder or pattern of pictures, or a video file.

    ``times``: a csv; None takes ``rate_hz`` from ``start_s`` on, and if that is 0, the names of the pictures or the
    rate of the video.

    Raises
    ------
    ParamError
        The files cannot be read, or the times are not known.
    """
    if times is not None and rate_hz:
        raise ParamError("rate_hz", f"'rate_hz' is {rate_hz:g}, but 'times' is given too", "remove one of them")
    start_us = round(start_s * 1e6)
    if is_pictures(path):
        files = find_pictures(path)
        if rate_hz:
            utimes = start_us + np.rint(np.arange(len(files)) * 1e6 / rate_hz).astype(np.int64)
            return Sequence(PictureFrames(files), Timeline(utimes))
        files, utimes = picture_times(files, times)
        return Sequence(PictureFrames(files), Timeline(utimes))
    frames = open_capture(path)
    if frames.is_live:
        frames.close()
        raise ParamError("path", f"'{path}' is not recorded", "use io.video for a camera or a stream")
    try:
        return Sequence(frames, _video_timeline(path, frames.rate_hz, times, rate_hz, start_us))
    except ParamError:
        frames.close()
        raise


def _video_timeline(path: Path, own_hz: float, times: Path | None, rate_hz: float, start_us: int) -> Timeline:
    if times is not None:
        return Timeline(row_times(times))
    if not (rate_hz or own_hz):
        raise ParamError("path", f"'{path}' does not declare a frame rate", "set 'rate_hz' or 'times'")
    return Timeline(None, rate_hz or own_hz, start_us)


class Timeline:
    """Times of frames in microseconds: recorded ones, or those of a constant rate.

    ``utimes``: int64 (n,), increasing, None for a constant ``rate_hz`` from ``start_us`` on.
    """

    def __init__(self, utimes: Longs | None, rate_hz: float = 0.0, start_us: int = 0) -> None:
        self._utimes, self._start_us = utimes, start_us
        if utimes is not None:
            rate_hz = 1e6 / float(np.median(np.diff(utimes))) if len(utimes) > 1 else ONE_PICTURE_HZ
        self.rate_hz = rate_hz
        """The typical rate."""

    def at_us(self, frame: int) -> int:
        """Return the time of a frame; after the last recorded time it goes on at the typical rate."""
        if self._utimes is None:
            return self._start_us + round(frame * 1e6 / self.rate_hz)
        last = len(self._utimes) - 1
        if frame <= last:
            return int(self._utimes[frame])
        return int(self._utimes[last]) + round((frame - last) * 1e6 / self.rate_hz)

    def has(self, frame: int) -> bool:
        """Whether the time of a frame is known."""
        return self._utimes is None or frame < len(self._utimes)

    @property
    def last_us(self) -> int | None:
        """The last recorded time, None at a constant rate."""
        return None if self._utimes is None else int(self._utimes[-1])
