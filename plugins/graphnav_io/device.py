"""Find what a camera's parameter names, and open it: a device, a stream, a pipe, or a file played as a camera."""

from __future__ import annotations

import math
import os
import stat
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple, Protocol

import cv2

from graphnav import CameraDevice, ParamError, cameras
from graphnav.arrays import Bytes
from graphnav_io.capture import FASTEST_HZ, check_camera, is_camera, is_stream, open_capture
from graphnav_io.frames import Frames
from graphnav_io.picture_size import check_pixels
from graphnav_io.pictures import PictureFrames, find_pictures, is_pictures

PIPELINE = "gst://"
PICTURES_HZ = 10.0
AUTOMATIC, MANUAL = 3.0, 1.0
"""Exposure of V4L2: the camera chooses it at its aperture, and a given one."""
PER_S = 10_000.0
"""V4L2 counts exposure in units of 0.1 ms."""
BUFFERS = 2
"""The one that OpenCV holds and the one that the driver fills: with one alone every other picture would be missed, and
more would keep old pictures if the process was suspended."""
LIST = "'graphnav cameras' lists them"


class Device(NamedTuple):
    """A source of pictures that a camera's parameter names."""

    kind: Literal["camera", "stream", "pipe", "pipeline", "file", "pictures"]
    source: str
    """For OpenCV."""
    name: str
    """For the user."""

    @property
    def is_played(self) -> bool:
        """Whether it is recorded: it is played at its own rate, and ends."""
        return self.kind in {"file", "pictures"}


class Wanted(NamedTuple):
    """Wishes to a camera; None and 0 leave the choice to it. ``timeout_s``: of streams."""

    size: tuple[int, int] | None
    rate_hz: float
    pixel_format: str | None
    exposure_s: float | None
    timeout_s: float


class OpenDevice(Protocol):
    """A device that delivers pictures; `read` waits for the next one."""

    rate_hz: float
    """0: not known."""
    told: Sequence[str]
    """Differences between the device and the wishes, a line each."""

    def read(self) -> tuple[Bytes, float] | None:
        """Return the next picture, red-green-blue, and the driver's stamp in seconds (0: none); None: there is none.

        Raises
        ------
        ValueError
            It cannot be decoded.
        """

    def close(self) -> None:
        """Release it."""


def find_device(device: Path | str) -> Device:
    """Return what a camera's parameter names, without opening it.

    Raises
    ------
    ParamError
        It names nothing, or several cameras, or what may not be opened.
    """
    text = str(device)
    if text.startswith(PIPELINE):
        return _pipeline(text.removeprefix(PIPELINE))
    path = Path(device)
    if is_stream(path):
        return Device("stream", text if isinstance(device, str) else text.replace(":/", "://", 1), text)
    if is_camera(path):
        return _checked(f"/dev/video{text}" if text.isdecimal() else text)
    if is_pictures(path):
        return Device("pictures", text, f"'{path}'")
    try:
        mode = path.stat().st_mode
    except OSError:
        return _named(path.name)
    if stat.S_ISFIFO(mode):
        return Device("pipe", text, f"the pipe '{path}'")
    return Device("file", os.path.abspath(path), f"'{path}'")


def open_device(device: Device, wanted: Wanted) -> OpenDevice:
    """Open it.

    Raises
    ------
    ParamError
        It cannot be opened or read.
    """
    try:
        if device.kind == "pictures":
            return _Played(PictureFrames(find_pictures(Path(device.source))), wanted)
        if device.kind == "file":
            return _Played(open_capture(Path(device.source)), wanted)
    except ParamError as error:
        raise ParamError("device", error.what, error.hint) from error
    return _Capture(device, wanted)


def _pipeline(text: str) -> Device:
    if not cv2.videoio_registry.hasBackend(cv2.CAP_GSTREAMER):
        what = "this OpenCV has no GStreamer, so that it cannot open a pipeline"
        raise ParamError("device", what, "give a camera, a URL or a file, or install an OpenCV that was built with it")
    return Device("pipeline", text, f"the pipeline '{text}'")


def _checked(path: str) -> Device:
    try:
        check_camera(Path(path))
    except ParamError as error:
        raise ParamError("device", error.what, error.hint or LIST) from error
    known = next((one.name for one in cameras(modes=False) if one.path == os.path.realpath(path)), "")
    return Device("camera", path, f"{known} ({path})" if known else path)


def _named(text: str) -> Device:
    """Return the camera whose name contains ``text``, regardless of case."""
    known = cameras(modes=False)
    found = [one for one in known if text.lower() in one.name.lower()]
    exact = [one for one in found if text.lower() == one.name.lower()]
    found = exact or found
    if len(found) == 1:
        return _checked(found[0].path)
    if found:
        what = f"'{text}' names {len(found)} cameras: {_listed(found)}"
        raise ParamError("device", what, f"give the number of one, such as {found[0].path.removeprefix('/dev/video')}")
    hint = f"this machine has {_listed(known)}" if known else f"this machine has no camera; {LIST}"
    raise ParamError("device", f"there is no camera, file or URL '{text}'", hint)


def _listed(found: Sequence[CameraDevice]) -> str:
    return ", ".join(f"{one.name} ({one.path})" for one in found)


class _Played:
    """A recording as a device."""

    told: Sequence[str] = ()

    def __init__(self, frames: Frames, wanted: Wanted) -> None:
        self._frames = frames
        self.rate_hz = wanted.rate_hz or frames.rate_hz or PICTURES_HZ

    def read(self) -> tuple[Bytes, float] | None:
        pixels = self._frames.read()
        return None if pixels is None else (pixels, 0.0)

    def close(self) -> None:
        self._frames.close()


class _Capture:
    """A camera, stream, pipe or pipeline by OpenCV."""

    def __init__(self, device: Device, wanted: Wanted) -> None:
        self._device = device
        self._has_stamps = device.kind == "camera"
        try:
            self._capture = _opened(device, wanted)
            is_open = self._capture.isOpened()
        except (cv2.error, SystemError) as error:
            raise ParamError("device", f"{device.name} cannot be opened") from error
        if not is_open:
            hint = "another program may use it" if device.kind == "camera" else ""
            raise ParamError("device", f"{device.name} cannot be opened", hint)
        self.told: Sequence[str] = tuple(self._configured(wanted)) if device.kind == "camera" else ()
        rate_hz = self._capture.get(cv2.CAP_PROP_FPS)
        is_known = device.kind == "camera" and math.isfinite(rate_hz) and 0 < rate_hz <= FASTEST_HZ
        self.rate_hz = rate_hz if is_known else 0.0

    def read(self) -> tuple[Bytes, float] | None:
        try:
            if not self._capture.grab():
                return None
            stamp_s = self._capture.get(cv2.CAP_PROP_POS_MSEC) / 1e3 if self._has_stamps else 0.0
            check_pixels(self._capture.get(cv2.CAP_PROP_FRAME_HEIGHT), self._capture.get(cv2.CAP_PROP_FRAME_WIDTH))
            is_decoded, pixels = self._capture.retrieve()
        except cv2.error as error:
            raise ValueError(f"a picture of {self._device.name} cannot be decoded") from error
        if not is_decoded:
            raise ValueError(f"a picture of {self._device.name} cannot be decoded")
        code = cv2.COLOR_GRAY2RGB if pixels.ndim == 2 else cv2.COLOR_BGR2RGB
        return cv2.cvtColor(pixels, code), stamp_s

    def close(self) -> None:
        self._capture.release()

    def _configured(self, wanted: Wanted) -> list[str]:
        """Ask the camera for what is wanted; return what it does not do."""
        capture, told = self._capture, []
        capture.set(cv2.CAP_PROP_BUFFERSIZE, BUFFERS)
        if wanted.pixel_format is not None:
            capture.set(cv2.CAP_PROP_FOURCC, cv2.VideoWriter.fourcc(*wanted.pixel_format))
            code = int(capture.get(cv2.CAP_PROP_FOURCC))
            given = code.to_bytes(4, "little", signed=code < 0).decode("latin-1")
            told += [] if given == wanted.pixel_format else [f"it gives {given}, not {wanted.pixel_format}"]
        if wanted.size is not None:
            for key, value in zip((cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT), wanted.size, strict=True):
                capture.set(key, value)
        if wanted.rate_hz:
            capture.set(cv2.CAP_PROP_FPS, wanted.rate_hz)
            given_hz = capture.get(cv2.CAP_PROP_FPS)
            is_given = not given_hz or abs(given_hz - wanted.rate_hz) < 0.5
            told += [] if is_given else [f"it gives {given_hz:g} Hz, not {wanted.rate_hz:g}"]
        if wanted.exposure_s is None:
            capture.set(cv2.CAP_PROP_AUTO_EXPOSURE, AUTOMATIC)
        elif not (
            capture.set(cv2.CAP_PROP_AUTO_EXPOSURE, MANUAL)
            and capture.set(cv2.CAP_PROP_EXPOSURE, max(1.0, round(PER_S * wanted.exposure_s)))
        ):
            told.append("it takes no exposure")
        return told


def _opened(device: Device, wanted: Wanted) -> cv2.VideoCapture:
    match device.kind:
        case "camera":
            given: tuple[Any, ...] = (device.source, cv2.CAP_V4L2)
        case "pipeline":
            given = (device.source, cv2.CAP_GSTREAMER)
        case _:
            timeout_ms = math.ceil(wanted.timeout_s * 1e3)
            keys = cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, cv2.CAP_PROP_READ_TIMEOUT_MSEC
            given = (device.source, cv2.CAP_FFMPEG, [keys[0], timeout_ms, keys[1], timeout_ms])
    return cv2.VideoCapture(*given)
