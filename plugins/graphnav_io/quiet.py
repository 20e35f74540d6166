"""Silence OpenCV and its codecs on standard error; exceptions report their errors."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import cv2

STDERR = 2
_here = threading.local()


@contextmanager
def quiet() -> Iterator[None]:
    """Discard output to file descriptor 2 in the block, including that of C code.

    FFmpeg's threads write at any time, so its log level is lowered permanently unless the environment sets it.
    """
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    if getattr(_here, "is_beside", False):
        yield
        return
    kept = os.dup(STDERR)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, STDERR)
    try:
        yield
    finally:
        os.dup2(kept, STDERR)
        os.close(nowhere)
        os.close(kept)


def quiet_beside() -> None:
    """Let `quiet` discard nothing in this thread from now on, but lower the log levels of OpenCV and FFmpeg.

    For a thread that reads beside others: what they write meanwhile must not be lost.
    """
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    _here.is_beside = True
