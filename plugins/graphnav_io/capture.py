"""Read frames from a video file, a camera or a stream through OpenCV."""

from __future__ import annotations

import math
import re
from pathlib import Path

import cv2

from graphnav import ParamError
from graphnav.arrays import Bytes
from graphnav_io.quiet import quiet

FASTEST_HZ = 1000.0
"""Streams without a frame rate report meaningless values above this."""

ANSI_ART = cv2.VideoWriter.fourcc(*"ansi")
"""FFmpeg renders text files as video."""

LACKING_FRAMES = 3
LACKING_RATIO = 0.02
"""A smaller deficit of frames may come from a rounded duration; a larger one means that the file is truncated."""

_URL = re.compile(r"^([a-z][a-z0-9+.-]*):/+")


def open_capture(path: Path) -> CaptureFrames:
    """Return the frames of a video file, a camera (by its number) or a stream (by its URL).

    Raises
    ------
    ParamError
        It does not exist, or OpenCV cannot read it.
    """
    text = _URL.sub(r"\1://", str(path))  # Path keeps one of two slashes
    if _URL.match(text):
        return _opened(text, f"the stream '{text}'", live=True)
    if text.isdecimal() and not path.exists():
        return _opened(int(text), f"camera {text}", live=True)
    if not path.exists():
        raise ParamError(
            "path", f"there is no file '{path}'", "give a video file, a folder of pictures, a camera's number or a URL"
        )
    if path.stat().st_size == 0:
        raise ParamError("path", f"'{path}' is empty")
    return _opened(text, f"'{path}'", live=False)


def _opened(source: str | int, name: str, *, live: bool) -> CaptureFrames:
    with quiet():
        capture = cv2.VideoCapture(source)
        is_text = capture.get(cv2.CAP_PROP_FOURCC) == ANSI_ART
        opened = capture.isOpened() and not is_text and (live or capture.grab())
    if not opened:
        capture.release()
        what = f"{name} cannot be opened" if live else f"{name} is not a complete video that OpenCV can read"
        raise ParamError("path", what)
    return CaptureFrames(capture, name, live=live)


def first_frame(frames: CaptureFrames) -> Bytes:
    """Return the first frame of a file.

    Raises
    ------
    ParamError
        It cannot be decoded.
    """
    try:
        pixels = frames.read()
    except ValueError as error:
        raise ParamError("path", str(error)) from error
    assert pixels is not None, "an open file has a first frame"
    return pixels


class CaptureFrames:
    """Frames of an open capture. Files, but not live sources, are read one frame ahead to detect the end."""

    def __init__(self, capture: cv2.VideoCapture, name: str, *, live: bool) -> None:
        self._capture, self._name, self.is_live = capture, name, live
        self._is_grabbed = not live
        self._count = 0
        rate = capture.get(cv2.CAP_PROP_FPS)
        self.rate_hz = rate if math.isfinite(rate) and 0 < rate <= FASTEST_HZ else 0.0

    @property
    def at_end(self) -> bool:
        """Whether a complete file has no frame left; a live source may always have another one."""
        return not (self.is_live or self._is_grabbed or self._is_truncated)

    def read(self) -> Bytes | None:
        """Return the next frame, red-green-blue, None after the last.

        Raises
        ------
        ValueError
            A frame cannot be decoded, or the file ends before the last frame that it declares.
        """
        with quiet():
            if self.is_live:
                self._is_grabbed = self._capture.grab()
            if not self._is_grabbed:
                self._check_complete()
                return None
            decoded, pixels = self._capture.retrieve()
            if not self.is_live:
                self._is_grabbed = self._capture.grab()
        if not decoded:
            raise ValueError(f"frame {self._count} of {self._name} cannot be decoded")
        self._count += 1
        rgb: Bytes = cv2.cvtColor(pixels, cv2.COLOR_GRAY2RGB if pixels.ndim == 2 else cv2.COLOR_BGR2RGB)
        return rgb

    def close(self) -> None:
        """Release the file or device."""
        self._capture.release()

    @property
    def _declared(self) -> float:
        return float(self._capture.get(cv2.CAP_PROP_FRAME_COUNT))

    @property
    def _is_truncated(self) -> bool:
        lacking = self._declared - self._count
        return lacking > max(LACKING_FRAMES, LACKING_RATIO * self._declared)

    def _check_complete(self) -> None:
        if not self.is_live and self._is_truncated:
            raise ValueError(f"{self._name} ends after {self._count} of {self._declared:.0f} frames: it is truncated")
