"""Frames as a video file."""

from __future__ import annotations

import errno
import importlib
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from typing import Any

import cv2

from graphnav import UserError, VideoFrames, written_aside

_H264 = "libx264"
_CODEC = "vp09"
"""OpenCV's only encoder that browsers play, several times slower than H.264 by PyAV."""


def write_frames(video: VideoFrames, path: Path) -> Path:
    """Write frames as a video that browsers play: H.264 by PyAV (extra ``video``) if it is installed, else VP9.

    The suffix of ``path`` has to be ``.mp4``.

    Raises
    ------
    UserError
        Neither PyAV nor this OpenCV can write such a video.
    OSError
        The file does not hold every frame, as on a disk that is full: the encoder itself raises nothing.
    """
    with _quiet(), written_aside(path) as aside:
        count = _write(video, aside)
        held = _count(aside)
        if held != count:
            free_mb = shutil.disk_usage(path.parent).free / 1e6
            raise OSError(errno.EIO, f"it holds {held} of {count} frames, and {free_mb:.0f} MB are free there")
    return path


def _write(video: VideoFrames, path: Path) -> int:
    """Write frames; return how many there were."""
    if _pyav() is not None:
        return _write_h264(video, path)
    writer: cv2.VideoWriter | None = None
    count = 0
    try:
        for _, frame in video.frames:
            if writer is None:
                writer = _open(path, video.rate_hz, *frame.shape[:2])
            writer.write(cv2.cvtColor(frame, cv2.COLOR_RGB2BGR))
            count += 1
    finally:
        if writer is not None:
            writer.release()
    return count


def _pyav() -> Any:
    """Return the module of PyAV, None where it is not installed or has no encoder of H.264."""
    try:
        av = importlib.import_module("av")
    except ImportError:
        return None
    return av if _H264 in av.codecs_available else None


def _write_h264(video: VideoFrames, path: Path) -> int:
    """Write frames by PyAV; return how many there were."""
    av, count = _pyav(), 0
    try:
        with av.open(str(path), "w", format="mp4", options={"movflags": "faststart"}) as container:
            stream = container.add_stream(_H264, rate=Fraction(video.rate_hz).limit_denominator(1000))
            stream.pix_fmt, stream.options = "yuv420p", {"crf": "20", "preset": "veryfast"}
            for _, frame in video.frames:
                if not count:
                    stream.height, stream.width = frame.shape[:2]
                container.mux(stream.encode(av.VideoFrame.from_ndarray(frame, format="rgb24")))
                count += 1
            container.mux(stream.encode())
    except av.FFmpegError as error:
        raise OSError(error.errno, error.strerror or str(error)) from error
    return count


@contextmanager
def _quiet() -> Iterator[None]:
    """Silence OpenCV in the block: exceptions report its errors."""
    level = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        yield
    finally:
        cv2.utils.logging.setLogLevel(level)


def _open(path: Path, rate_hz: float, rows: int, cols: int) -> cv2.VideoWriter:
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*_CODEC), rate_hz, (cols, rows))
    if not writer.isOpened():
        raise UserError.of(
            f"neither PyAV nor this OpenCV ({cv2.__version__}) can write a video into {path.parent}",
            "install PyAV (pip install av), or leave out the video",
        )
    return writer


def _count(path: Path) -> int:
    """Return the number of frames that a reader finds, 0 where it finds no video."""
    capture = cv2.VideoCapture(str(path))
    try:
        return round(capture.get(cv2.CAP_PROP_FRAME_COUNT)) if capture.isOpened() else 0
    finally:
        capture.release()
