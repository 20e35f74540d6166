"""Read frames from a video file, a camera or a stream through OpenCV."""

from __future__ import annotations

import math
import os
import re
import stat
import threading
from collections.abc import Callable
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any, TypeVar

import cv2

from graphnav import ParamError
from graphnav.arrays import Bytes
from graphnav_io.picture_size import check_pixels
from graphnav_io.quiet import quiet

FASTEST_HZ = 1000.0
"""Streams without a frame rate report meaningless values above this."""
ANSI_ART = cv2.VideoWriter.fourcc(*"ansi")
"""FFmpeg renders text files as video."""
LACKING_FRAMES = 3
LACKING_RATIO = 0.02
"""A smaller deficit of frames may come from a rounded duration; a larger one means that the file is truncated."""
COMPLETE = "a complete video that OpenCV can read"
OPEN_TIMEOUT_S = 30.0
"""Of FFmpeg through OpenCV, where a graph does not set another one."""
VIDEO_DEVICES = 81
"""Major number of the device files of cameras on Linux."""
_URL = re.compile(r"^([a-z][a-z0-9+.-]*):/+", re.IGNORECASE)
T = TypeVar("T")


def is_stream(path: Path) -> bool:
    """Return whether a path is a URL, which is read from another program or machine."""
    return _URL.match(str(path)) is not None


def is_camera(path: Path) -> bool:
    """Return whether a path names a camera of this machine: its number, or a file in /dev."""
    return (str(path).isdecimal() and not path.exists()) or path.absolute().is_relative_to("/dev")


def check_camera(path: Path) -> None:
    """Check that a camera exists, without opening it: others may use it, and it takes a second.

    Raises
    ------
    ParamError
        It does not exist, or is another device.
    """
    device = Path(f"/dev/video{path}") if str(path).isdecimal() else path
    try:
        found = device.stat()
    except OSError:
        cameras = ", ".join(sorted(map(str, Path("/dev").glob("video*")))) or "no camera"
        raise ParamError("path", f"there is no camera {path}", f"this machine has {cameras}") from None
    if not stat.S_ISCHR(found.st_mode) or os.major(found.st_rdev) != VIDEO_DEVICES:
        raise ParamError("path", f"{device} is not a camera", "give a camera's number, or its file such as /dev/video0")
    if not os.access(device, os.R_OK | os.W_OK):
        raise ParamError("path", f"camera {path} may not be opened", "add the user to the group 'video'")


def open_capture(path: Path, open_timeout_s: float = OPEN_TIMEOUT_S) -> CaptureFrames:
    """Return the frames of a video file, a camera (by its number or device file) or a stream (by its URL).

    Ctrl-C interrupts the wait for a camera or a stream. ``open_timeout_s``: how long a stream is waited for.

    Raises
    ------
    ParamError
        It does not exist, or OpenCV cannot read it.
    """
    text = str(path)
    if is_stream(path):
        text = _URL.sub(r"\1://", text)  # Path keeps one of two slashes
        wait = [cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, math.ceil(open_timeout_s * 1e3)]
        return _opened((text, cv2.CAP_FFMPEG, wait), f"the stream '{text}'", live=True)
    if is_camera(path):
        check_camera(path)
        return _opened((int(text) if text.isdecimal() else text, cv2.CAP_V4L2), f"camera {path}", live=True)
    if not path.exists():
        raise ParamError(
            "path", f"there is no file '{path}'", "give a video file, a folder of pictures, a camera's number or a URL"
        )
    found = path.stat()
    if not stat.S_ISREG(found.st_mode):
        raise ParamError("path", f"'{path}' is not a regular file", "give a video file, a camera's number or a URL")
    if found.st_size == 0:
        raise ParamError("path", f"'{path}' is empty")
    return _opened((os.path.abspath(path),), f"'{path}'", live=False)  # a relative name might be read as a protocol


def _opened(source: tuple[Any, ...], name: str, *, live: bool) -> CaptureFrames:
    """Return the frames of what ``source``, the arguments of VideoCapture, names."""
    refused = ParamError("path", f"{name} cannot be opened" if live else f"{name} is not {COMPLETE}")
    try:
        with quiet():
            capture = interruptible(lambda: cv2.VideoCapture(*source)) if live else cv2.VideoCapture(*source)
            is_text = capture.get(cv2.CAP_PROP_FOURCC) == ANSI_ART
            check_pixels(capture.get(cv2.CAP_PROP_FRAME_HEIGHT), capture.get(cv2.CAP_PROP_FRAME_WIDTH))
            opened = capture.isOpened() and not is_text and (live or capture.grab())
    except (cv2.error, SystemError) as error:
        raise refused from error
    except ValueError as error:
        raise ParamError("path", f"{name} has too large pictures: {error}") from error
    if not opened:
        capture.release()
        raise refused
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
        self._is_waited_for = False
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
        try:
            with quiet():
                if self.is_live:
                    self._is_grabbed = self._waited_for()
                if not self._is_grabbed:
                    self._check_complete()
                    return None
                decoded, pixels = self._capture.retrieve()
                if not self.is_live:
                    self._is_grabbed = self._capture.grab()
        except cv2.error:
            decoded = False
        if not decoded:
            raise ValueError(f"frame {self._count} of {self._name} cannot be decoded")
        self._count += 1
        rgb: Bytes = cv2.cvtColor(pixels, cv2.COLOR_GRAY2RGB if pixels.ndim == 2 else cv2.COLOR_BGR2RGB)
        return rgb

    def close(self) -> None:
        """Release the file or device, unless another thread still waits for its next frame."""
        if not self._is_waited_for:
            self._capture.release()

    def _waited_for(self) -> bool:
        """Return whether there is a next frame of a live source."""
        self._is_waited_for = True
        found = interruptible(self._capture.grab)
        self._is_waited_for = False
        return found

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


def interruptible(call: Callable[[], T], timeout_s: float | None = None) -> T:
    """Return what ``call`` returns, made in another thread, which is left behind if this one is interrupted.

    So Ctrl-C is obeyed during calls of C code: Python handles signals between two steps of its main thread.

    Raises
    ------
    BaseException
        What ``call`` raises.
    TimeoutError
        It has not returned after ``timeout_s``.
    """
    outcome: SimpleQueue[tuple[bool, T | BaseException]] = SimpleQueue()

    def work() -> None:
        try:
            outcome.put((True, call()))
        except BaseException as error:  # noqa: BLE001 - raised again below
            outcome.put((False, error))

    threading.Thread(target=work, name="capture", daemon=True).start()
    try:
        is_ok, found = outcome.get(timeout=timeout_s)
    except Empty:
        raise TimeoutError from None
    if not is_ok:
        assert isinstance(found, BaseException)
        raise found
    return found  # type: ignore[return-value]
