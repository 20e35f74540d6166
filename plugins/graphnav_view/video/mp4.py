"""Frames as a video file."""

from __future__ import annotations

import errno
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2

from graphnav import UserError, VideoFrames
from graphnav_view.atomic_file import written_aside

_CODEC = "mp4v"


def write_frames(video: VideoFrames, path: Path) -> Path:
    """Write frames as MPEG-4; the suffix of ``path`` has to be ``.mp4``.

    Raises
    ------
    UserError
        This OpenCV cannot write video.
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
            f"this OpenCV ({cv2.__version__}) cannot write MPEG-4 into {path.parent}",
            "install opencv-python-headless from PyPI, which brings FFmpeg, or leave out the video",
        )
    return writer


def _count(path: Path) -> int:
    """Return the number of frames that a reader finds, 0 where it finds no video."""
    capture = cv2.VideoCapture(str(path))
    try:
        return round(capture.get(cv2.CAP_PROP_FRAME_COUNT)) if capture.isOpened() else 0
    finally:
        capture.release()
