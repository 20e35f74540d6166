"""Open recorded pictures or a video together with their times."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from graphnav import ParamError
from graphnav_io.capture import open_capture
from graphnav_io.frames import Frames
from graphnav_io.picture_times import picture_times, row_times
from graphnav_io.pictures import PictureFrames, find_pictures, is_pictures
from graphnav_io.timeline import Timeline


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
