"""The cameras of this machine, by Video4Linux: its files in /sys, and what each device answers.

Four queries of one ioctl interface, which has not changed since 2009; so no library is needed for them.
"""

from __future__ import annotations

import os
import struct
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

if sys.platform != "win32":
    import fcntl

_QUERY_CAPABILITIES, _FORMATS, _SIZES, _INTERVALS = 0x80685600, 0xC0405602, 0xC02C564A, 0xC034564B
"""VIDIOC_QUERYCAP, VIDIOC_ENUM_FMT, VIDIOC_ENUM_FRAMESIZES, VIDIOC_ENUM_FRAMEINTERVALS."""
_CAPABILITIES = struct.Struct("=16s32s32sII I12x")
"""struct v4l2_capability: driver, card, bus, version, capabilities, device_caps."""
_FORMAT = struct.Struct("=III32sI16x")
"""struct v4l2_fmtdesc: index, type, flags, description, pixelformat."""
_SIZE = struct.Struct("=III6I8x")
"""struct v4l2_frmsizeenum: index, pixel_format, type; width, height, or minimum, maximum and step of both."""
_INTERVAL = struct.Struct("=IIIII6I8x")
"""struct v4l2_frmivalenum: index, pixel_format, width, height, type; fractions, s: one, or minimum, maximum, step."""
_HAS_DEVICE_CAPS, _CAPTURE, _CAPTURE_PLANES = 0x80000000, 0x1, 0x1000
_BUFFER_CAPTURE, _BUFFER_CAPTURE_PLANES = 1, 9
_DISCRETE = 1
_MAX_ENTRIES = 256
"""Of each list: a driver that never ends it is not waited for."""
SYSTEM, DEVICES = Path("/sys/class/video4linux"), Path("/dev")
Ioctl = Callable[[int, int, bytearray], object]


class CameraMode(NamedTuple):
    """A pixel format and a size that a camera has, and the rates at which it delivers them.

    ``rates_hz``: highest first; empty if the driver does not tell. Of a driver that takes any size up to one, that one.
    """

    pixel_format: str
    """Four letters, such as MJPG or YUYV."""
    description: str
    cols: int
    rows: int
    rates_hz: tuple[float, ...]


class CameraDevice(NamedTuple):
    """A camera of this machine."""

    path: str
    """Its device file."""
    name: str
    driver: str
    """Empty where ``problem`` is not."""
    modes: tuple[CameraMode, ...]
    """In the order of the driver; empty unless they were asked for."""
    problem: str
    """Why it could not be asked, empty if it could."""


def cameras(
    *, modes: bool = True, system: Path = SYSTEM, devices: Path = DEVICES, ioctl: Ioctl | None = None
) -> list[CameraDevice]:
    """Return the cameras of this machine by the numbers of their devices; none on a system other than Linux.

    A camera often has several devices; those that deliver no pictures, such as metadata, are left out. A device is
    opened to be asked, which disturbs no program that uses it. ``modes``: ask for these too, some milliseconds each.
    ``system``, ``devices``, ``ioctl``: in place of those of Linux.
    """
    found = []
    for folder in sorted(system.glob("video*"), key=_number):
        camera = _asked(folder, devices / folder.name, ioctl or _ioctl, modes=modes)
        if camera is not None:
            found.append(camera)
    return found


def _ioctl(fd: int, request: int, argument: bytearray) -> object:
    assert sys.platform != "win32", "there is no /sys"
    return fcntl.ioctl(fd, request, argument, True)  # noqa: FBT003 - it changes the argument


def _number(folder: Path) -> tuple[int, str]:
    digits = folder.name.removeprefix("video")
    return (int(digits) if digits.isdecimal() else sys.maxsize, folder.name)


def _asked(folder: Path, device: Path, ioctl: Ioctl, *, modes: bool) -> CameraDevice | None:
    """Return the camera of a device, None if it delivers no pictures."""
    name = _line(folder / "name") or device.name
    try:
        fd = os.open(device, os.O_RDWR | os.O_NONBLOCK)
    except OSError as error:
        # the first device of a camera is the one with pictures
        is_first = _line(folder / "index") in {"", "0"}
        return CameraDevice(str(device), name, "", (), f"cannot be opened: {error.strerror}") if is_first else None
    try:
        driver, _, _, _, capabilities, of_device = _CAPABILITIES.unpack(
            _answer(ioctl, fd, _QUERY_CAPABILITIES, _CAPABILITIES.size)
        )
        can = of_device if capabilities & _HAS_DEVICE_CAPS else capabilities
        if not can & (_CAPTURE | _CAPTURE_PLANES):
            return None
        buffer = _BUFFER_CAPTURE if can & _CAPTURE else _BUFFER_CAPTURE_PLANES
        found = tuple(_modes(ioctl, fd, buffer)) if modes else ()
    except OSError as error:
        return CameraDevice(str(device), name, "", (), f"does not answer: {error.strerror}")
    finally:
        os.close(fd)
    return CameraDevice(str(device), name, _text(driver), found, "")


def _modes(ioctl: Ioctl, fd: int, buffer: int) -> Iterator[CameraMode]:
    for answer in _listed(ioctl, fd, _FORMATS, _FORMAT, (buffer, 0, b"", 0)):
        _, _, _, described, code = answer
        letters = struct.pack("=I", code).decode("latin-1").strip()
        for _, _, kind, *numbers in _listed(ioctl, fd, _SIZES, _SIZE, (code, *[0] * 7)):
            cols, rows = (numbers[0], numbers[1]) if kind == _DISCRETE else (numbers[1], numbers[4])
            yield CameraMode(letters, _text(described), cols, rows, _rates_hz(ioctl, fd, code, cols, rows))
            if kind != _DISCRETE:
                break


def _rates_hz(ioctl: Ioctl, fd: int, code: int, cols: int, rows: int) -> tuple[float, ...]:
    rates = []
    for answer in _listed(ioctl, fd, _INTERVALS, _INTERVAL, (code, cols, rows, *[0] * 7)):
        _, _, _, _, kind, *numbers = answer
        ends = [numbers[:2]] if kind == _DISCRETE else [numbers[:2], numbers[2:4]]
        rates += [below / above for above, below in ends if above]
        if kind != _DISCRETE:
            break
    return tuple(sorted(set(rates), reverse=True))


def _listed(
    ioctl: Ioctl, fd: int, request: int, layout: struct.Struct, rest: tuple[object, ...]
) -> Iterator[tuple[Any, ...]]:
    """Yield what a device lists, until it refuses an index."""
    for index in range(_MAX_ENTRIES):
        argument = bytearray(layout.pack(index, *rest))
        try:
            ioctl(fd, request, argument)
        except OSError:
            return
        yield layout.unpack(argument)


def _answer(ioctl: Ioctl, fd: int, request: int, size: int) -> bytearray:
    argument = bytearray(size)
    ioctl(fd, request, argument)
    return argument


def _line(file: Path) -> str:
    try:
        return file.read_text(errors="replace").strip()
    except OSError:
        return ""


def _text(data: bytes) -> str:
    return data.partition(b"\0")[0].decode(errors="replace")
