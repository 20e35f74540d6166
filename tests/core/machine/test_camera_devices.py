"""Cameras are found in /sys and asked by ioctl; the answers here are packed by the kernel's structs, through ctypes."""

from __future__ import annotations

import ctypes
import errno
import json
import os
from ctypes import c_char, c_uint32
from pathlib import Path
from typing import ClassVar

import pytest

from graphnav.core.cli import main
from graphnav.core.machine import CameraDevice, cameras

HD, SMALL = (1280, 720), (640, 480)


class Capability(ctypes.Structure):
    """As in linux/videodev2.h, and so are those below."""

    _fields_ = (
        ("driver", c_char * 16),
        ("card", c_char * 32),
        ("bus_info", c_char * 32),
        ("version", c_uint32),
        ("capabilities", c_uint32),
        ("device_caps", c_uint32),
        ("reserved", c_uint32 * 3),
    )


class FormatDescription(ctypes.Structure):
    _fields_ = (
        ("index", c_uint32),
        ("type", c_uint32),
        ("flags", c_uint32),
        ("description", c_char * 32),
        ("pixelformat", c_uint32),
        ("mbus_code", c_uint32),
        ("reserved", c_uint32 * 3),
    )


class FrameSize(ctypes.Structure):
    _fields_ = (
        ("index", c_uint32),
        ("pixel_format", c_uint32),
        ("type", c_uint32),
        ("numbers", c_uint32 * 6),
        ("reserved", c_uint32 * 2),
    )


class FrameInterval(ctypes.Structure):
    _fields_ = (
        ("index", c_uint32),
        ("pixel_format", c_uint32),
        ("width", c_uint32),
        ("height", c_uint32),
        ("type", c_uint32),
        ("numbers", c_uint32 * 6),
        ("reserved", c_uint32 * 2),
    )


def request(direction: int, number: int, kind: type[ctypes.Structure]) -> int:
    """Return a request as the kernel's macros _IOR (2) and _IOWR (3) make it."""
    return direction << 30 | ctypes.sizeof(kind) << 16 | ord("V") << 8 | number


class Driver:
    """Answers as a webcam does; its second device has metadata alone, its third sizes by steps."""

    FORMATS = ((b"Motion-JPEG", b"MJPG"), (b"YUYV 4:2:2", b"YUYV"))
    SIZES: ClassVar = {b"MJPG": [HD, SMALL], b"YUYV": [SMALL]}
    RATES: ClassVar = {HD: [(1, 30)], SMALL: [(1, 30), (2, 15)]}

    def __init__(self, devices: Path) -> None:
        self._devices = devices

    def __call__(self, fd: int, asked: int, argument: bytearray) -> None:
        number = int(Path(os.readlink(f"/proc/self/fd/{fd}")).name.removeprefix("video"))
        answers = {
            request(2, 0, Capability): self._capability,
            request(3, 2, FormatDescription): self._format,
            request(3, 74, FrameSize): self._size,
            request(3, 75, FrameInterval): self._interval,
        }
        answers[asked](argument, number)

    def _capability(self, argument: bytearray, number: int) -> None:
        if number == 4:
            raise OSError(errno.ENOTTY, "Inappropriate ioctl for device")
        found = Capability.from_buffer(argument)
        found.driver, found.card = b"uvcvideo", b"HD Webcam"
        found.capabilities, found.device_caps = 0x84A00001, 0x04A00000 if number == 1 else 0x04200001

    def _format(self, argument: bytearray, number: int) -> None:
        found = FormatDescription.from_buffer(argument)
        assert found.type == 1
        if found.index >= len(self.FORMATS):
            raise OSError(errno.EINVAL, "Invalid argument")
        found.description, letters = self.FORMATS[found.index]
        found.pixelformat = int.from_bytes(letters, "little")

    def _size(self, argument: bytearray, number: int) -> None:
        found = FrameSize.from_buffer(argument)
        sizes = self.SIZES[int(found.pixel_format).to_bytes(4, "little")]
        if number == 2:
            found.type, found.numbers = 3, (16, 1920, 8, 16, 1080, 8)
        elif found.index < len(sizes):
            found.type, found.numbers = 1, (*sizes[found.index], 0, 0, 0, 0)
        else:
            raise OSError(errno.EINVAL, "Invalid argument")

    def _interval(self, argument: bytearray, number: int) -> None:
        found = FrameInterval.from_buffer(argument)
        rates = self.RATES.get((found.width, found.height), [])
        if number == 2:
            found.type, found.numbers = 2, (1, 60, 1, 5, 0, 1)
        elif found.index < len(rates):
            found.type, found.numbers = 1, (*rates[found.index], 0, 0, 0, 0)
        else:
            raise OSError(errno.EINVAL, "Invalid argument")


@pytest.fixture
def machine(tmp_path: Path) -> Path:
    """A tree with the files of /sys/class/video4linux and /dev."""
    for number, name in ((0, "HD Webcam"), (1, "HD Webcam"), (2, "Grabber"), (10, "Old"), (4, "Not one")):
        folder = tmp_path / "sys" / f"video{number}"
        folder.mkdir(parents=True)
        (folder / "name").write_text(f"{name}\n")
        (folder / "index").write_text("1\n" if number == 1 else "0\n")
        (tmp_path / "dev").mkdir(exist_ok=True)
        if number != 10:
            (tmp_path / "dev" / f"video{number}").touch()
    return tmp_path


def found_on(machine: Path, *, modes: bool = True) -> list[CameraDevice]:
    devices = machine / "dev"
    return cameras(modes=modes, system=machine / "sys", devices=devices, ioctl=Driver(devices))


def test_a_webcam_has_its_formats_sizes_and_rates(machine: Path) -> None:
    webcam = found_on(machine)[0]
    assert (webcam.path, webcam.name, webcam.driver) == (f"{machine}/dev/video0", "HD Webcam", "uvcvideo")
    assert [tuple(mode) for mode in webcam.modes] == [
        ("MJPG", "Motion-JPEG", *HD, (30.0,)),
        ("MJPG", "Motion-JPEG", *SMALL, (30.0, 7.5)),
        ("YUYV", "YUYV 4:2:2", *SMALL, (30.0, 7.5)),
    ]


def test_sizes_by_steps_are_told_by_the_largest_and_both_ends_of_the_rate(machine: Path) -> None:
    grabber = found_on(machine)[1]
    assert [(mode.cols, mode.rows, mode.rates_hz) for mode in grabber.modes] == [(1920, 1080, (60.0, 5.0))] * 2


def test_devices_stand_by_number_and_those_without_pictures_are_left_out(machine: Path) -> None:
    found = found_on(machine, modes=False)
    assert [Path(one.path).name for one in found] == ["video0", "video2", "video4", "video10"]
    assert [one.problem for one in found] == [
        "",
        "",
        "does not answer: Inappropriate ioctl for device",
        "cannot be opened: No such file or directory",
    ]
    assert not any(one.modes for one in found)


def test_a_machine_without_cameras_has_none(tmp_path: Path) -> None:
    assert cameras(system=tmp_path / "sys", devices=tmp_path) == []


def test_the_command_lists_cameras(
    machine: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    listed = found_on(machine)
    monkeypatch.setattr("graphnav.cameras", lambda: listed)
    assert main(["cameras"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"HD Webcam: device {machine}/dev/video0 ({machine}/dev/video0), uvcvideo"
    told = [line.split() for line in lines[1:9]]
    assert ["MJPG", "Motion-JPEG", "1280x720", "30"] in told
    assert ["640x480", "30,", "7.5"] in told
    assert main(["cameras", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)[0]["modes"][0]["rates_hz"] == [30.0]


def test_the_command_says_what_to_try_without_a_camera(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("graphnav.cameras", list)
    assert main(["cameras"]) == 1
    out = capsys.readouterr().out
    assert out.startswith("no camera is connected: there is no device with pictures in /dev/video*\n")
    assert "graphnav run camera_flow --set camera.device=clip.mp4" in out
