"""Silence OpenCV and its codecs on standard error; exceptions report their errors."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager

STDERR = 2
_entering = threading.Lock()
_kept: list[int] = []
"""Standard error itself, for each thread within the block: the last one to leave restores it."""


@contextmanager
def quiet() -> Iterator[None]:
    """Discard output to file descriptor 2 in the block, including that of C code. Several threads may be in it.

    FFmpeg's threads write at any time, so its log level is lowered permanently unless the environment sets it.
    """
    quiet_ffmpeg()
    with _entering:
        _kept.append(os.dup(_kept[0] if _kept else STDERR))
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, STDERR)
        os.close(nowhere)
    try:
        yield
    finally:
        with _entering:
            kept = _kept.pop()
            if not _kept:
                os.dup2(kept, STDERR)
            os.close(kept)


def quiet_ffmpeg() -> None:
    """Lower FFmpeg's log level, unless the environment sets it."""
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
