"""A camera delivers the newest picture in wall time, tells what becomes of its device, and never waits for it."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from graphnav_io import device as devices
from graphnav_io.camera import Camera
from graphnav_io.capture import interruptible
from graphnav_io.device import PIPELINE, find_device
from graphnav_io.driver_clock import DriverClock
from graphnav_io.quiet import quiet, quiet_beside

from graphnav import CameraDevice, Finished, ParamError

PATIENCE_S = 60.0
SERVER = Path(__file__).with_name("mjpeg_server.py")
WriteVideo = Callable[..., Path]


class Watched:
    """A camera that is stepped as a run would, and what came of it."""

    def __init__(self, camera: Camera) -> None:
        self.camera = camera
        self.stamps_s: list[float] = []
        self.told: list[str] = []
        self.shapes: set[tuple[int, ...]] = set()
        camera.check()
        camera.reset(0)

    def until(self, holds: Callable[[], bool]) -> None:
        """Step until something holds."""
        end_s = time.monotonic() + PATIENCE_S
        while not holds():
            assert time.monotonic() < end_s, f"it never came: {self.told}"
            self.told += self.camera.notices()
            if (taken_s := self.camera.arrived_s()) is not None:
                image = self.camera.step()
                self.stamps_s.append(taken_s)
                self.shapes.add(image.pixels.shape)
            time.sleep(0.002)

    def to_end(self) -> None:
        """Step to the end of a recording."""
        with pytest.raises(Finished, match="end"):
            self.until(lambda: False)
        self.told += self.camera.notices()


@pytest.fixture
def watched() -> Iterator[Callable[..., Watched]]:
    """Return a function that opens a camera with parameters."""
    made: list[Watched] = []

    def make(**params: Any) -> Watched:
        made.append(Watched(Camera(**params)))
        return made[-1]

    yield make
    for one in made:
        one.camera.close()


def test_a_video_is_played_in_its_own_time_and_ends(write_video: WriteVideo, watched: Callable[..., Watched]) -> None:
    path = write_video(rate_hz=40.0, frames=8)
    begin_s = time.monotonic()
    camera = watched(device=path)
    camera.to_end()
    assert time.monotonic() - begin_s >= 7 / 40
    counts = camera.camera.summary()
    assert counts["pictures"] == len(camera.stamps_s) >= 1
    assert counts["pictures"] + counts["replaced"] == 8
    assert camera.stamps_s == sorted(set(camera.stamps_s))
    assert all(begin_s <= stamp_s <= time.monotonic() for stamp_s in camera.stamps_s)
    assert camera.told == [
        f"'{path}' gives 64x48 at 40 Hz; pictures are stamped by the time of arrival",
        f"ended: '{path}' has no picture left",
    ]


def test_only_the_newest_picture_is_given(write_video: WriteVideo, watched: Callable[..., Watched]) -> None:
    camera = watched(device=write_video("a.avi", "MJPG", rate_hz=200.0, frames=6), gray=True).camera
    receiver = camera._receiver
    assert receiver is not None
    receiver._thread.join(PATIENCE_S)
    assert camera.arrived_s() is not None
    assert camera.step().pixels[:, :24].mean() == pytest.approx(40, abs=4)  # of the last one, number 5
    assert camera.arrived_s() is not None
    with pytest.raises(Finished):
        camera.step()
    assert camera.summary() == {"pictures": 1, "replaced": 5, "reopened": 0}


def test_a_folder_is_played_at_the_rate_that_is_given(folder: Path, watched: Callable[..., Watched]) -> None:
    camera = watched(device=folder, rate_hz=100.0, size=(32, 24))
    camera.to_end()
    assert camera.shapes == {(24, 32, 3)}
    assert camera.told[0] == f"'{folder}' gives 64x48 at 100 Hz; pictures are stamped by the time of arrival"


def test_another_size_than_asked_for_is_told_and_used(write_video: WriteVideo, watched: Callable[..., Watched]) -> None:
    camera = watched(device=write_video(frames=2), camera_size=(640, 480))
    camera.to_end()
    assert camera.shapes == {(48, 64, 3)}
    assert "gives 64x48, not 640x480 as asked, at 20 Hz;" in camera.told[0]


def test_a_file_that_was_cut_off_says_so(write_video: WriteVideo, watched: Callable[..., Watched]) -> None:
    path = write_video("a.avi", "MJPG")
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    camera = watched(device=path, rate_hz=500.0)
    camera.to_end()
    assert camera.told[-1].startswith(f"ended: '{path}' ends after ")
    assert camera.told[-1].endswith("of 30 frames: it is truncated")


def test_a_pipe_that_stalls_gives_nothing_and_then_goes_on(
    write_video: WriteVideo, tmp_path: Path, watched: Callable[..., Watched]
) -> None:
    data = write_video("a.avi", "MJPG").read_bytes()
    pipe, goes_on = tmp_path / "pipe", threading.Event()
    os.mkfifo(pipe)

    def write() -> None:
        with pipe.open("wb", buffering=0) as file:
            file.write(data[: len(data) // 2])
            goes_on.wait(PATIENCE_S)
            file.write(data[len(data) // 2 :])

    writer = threading.Thread(target=write, daemon=True)
    writer.start()
    camera = watched(device=pipe)
    camera.until(lambda: bool(camera.stamps_s))
    while camera.camera.arrived_s() is not None:  # what was written before it stalled
        camera.camera.step()
        time.sleep(0.05)
    before = len(camera.stamps_s)
    goes_on.set()
    camera.until(lambda: len(camera.stamps_s) > before)
    camera.until(lambda: any(one.startswith("lost: ") for one in camera.told))  # the writer has closed it
    writer.join(PATIENCE_S)
    assert camera.told[-1] == (
        f"lost: the pipe '{pipe}' gives no picture any more; it is opened again as soon as that is possible"
    )


def test_a_pipe_without_a_writer_is_not_waited_for_longer_than_asked(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    camera = Camera(device=pipe, timeout_s=0.1)
    with pytest.raises(ParamError) as raised:
        camera.reset(0)
    assert (raised.value.param, raised.value.what) == ("device", f"the pipe '{pipe}' was not open after 0.1 s")
    os.close(os.open(pipe, os.O_WRONLY))  # lets the thread go


@pytest.mark.long
def test_a_network_camera_that_dies_is_opened_again_when_it_is_back(
    tmp_path: Path, watched: Callable[..., Watched]
) -> None:
    cv2.imwrite(str(tmp_path / "a.jpg"), np.full((48, 64), 90, np.uint8))

    def serve(port: str) -> subprocess.Popen[str]:
        words = [sys.executable, "-S", str(SERVER), port, str(tmp_path / "a.jpg")]
        return subprocess.Popen(words, stdout=subprocess.PIPE, text=True)

    def port_of(server: subprocess.Popen[str]) -> str:
        assert server.stdout is not None
        with closing(server.stdout):
            return server.stdout.readline().strip()

    server = serve("0")
    try:
        port = port_of(server)
        camera = watched(device=f"http://127.0.0.1:{port}/a", gray=True)
        camera.until(lambda: len(camera.stamps_s) > 2)
        server.kill()
        server.wait()
        camera.until(lambda: any(one.startswith("lost: ") for one in camera.told))
        server = serve(port)
        assert port_of(server) == port
        before = len(camera.stamps_s)
        camera.until(lambda: len(camera.stamps_s) > before and len(camera.told) > 2)
    finally:
        server.kill()
        server.wait()
    gives = f"http://127.0.0.1:{port}/a gives 64x48; pictures are stamped by the time of arrival"
    lost = f"lost: http://127.0.0.1:{port}/a gives no picture any more; it is opened again as soon as that is possible"
    assert camera.told == [gives, lost, gives]
    assert camera.camera.summary()["reopened"] == 1
    assert camera.shapes == {(48, 64)}


@pytest.mark.parametrize(
    ("device", "what", "hint"),
    [
        ("97", "there is no camera /dev/video97", "this machine has "),
        ("/dev/null", "/dev/null is not a camera", "give a camera's number"),
        ("http://127.0.0.1:9/a", "http://127.0.0.1:9/a cannot be opened", ""),
        (
            "no such",
            "there is no camera, file or URL 'no such'",
            "this machine has no camera; 'graphnav cameras' lists",
        ),
        (
            f"{PIPELINE}v4l2src ! appsink",
            "this OpenCV has no GStreamer, so that it cannot open a pipeline",
            "give a ca",
        ),
    ],
)
def test_what_is_not_a_camera_is_refused_in_one_line(
    device: str, what: str, hint: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(devices, "cameras", lambda **_: [])
    monkeypatch.setattr(cv2.videoio_registry, "hasBackend", lambda _: False)
    with pytest.raises(ParamError) as raised:
        Camera(device=device if "://" in device else Path(device)).reset(0)
    assert (raised.value.param, raised.value.what) == ("device", what)
    assert str(raised.value.hint).startswith(hint)


def test_a_camera_is_found_by_a_part_of_its_name(monkeypatch: pytest.MonkeyPatch) -> None:
    names = ("HD Webcam C615", "HD Webcam", "Integrated Camera")
    known = [CameraDevice(f"/dev/video{2 * k}", name, "uvcvideo", (), "") for k, name in enumerate(names)]
    monkeypatch.setattr(devices, "cameras", lambda **_: known)
    monkeypatch.setattr(devices, "check_camera", lambda _: None)
    for text, path in (("c615", "/dev/video0"), ("hd webcam", "/dev/video2"), ("Integrated", "/dev/video4")):
        assert find_device(Path("/graphs") / text).source == path
    assert find_device(Path("4")).name == "Integrated Camera (/dev/video4)"
    with pytest.raises(ParamError) as raised:
        find_device(Path("webcam"))
    assert raised.value.what == "'webcam' names 2 cameras: HD Webcam C615 (/dev/video0), HD Webcam (/dev/video2)"
    with pytest.raises(ParamError, match="there is no camera, file or URL 'kinect'"):
        find_device(Path("kinect"))


def test_a_camera_that_may_not_be_opened_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    device = os.stat_result((0o020000, *[0] * 9), {"st_rdev": os.makedev(81, 0)})
    monkeypatch.setattr(Path, "stat", lambda *_, **__: device)
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(ParamError) as raised:
        find_device(Path("/dev/video0"))
    assert (raised.value.what, raised.value.hint) == (
        "camera /dev/video0 may not be opened",
        "add the user to the group 'video'",
    )


def test_the_pixel_format_has_four_letters(folder: Path) -> None:
    with pytest.raises(ParamError, match="'pixel_format' is 'JPEG2000', which is not four letters"):
        Camera(device=folder, pixel_format="JPEG2000").check()


def test_the_stamps_of_a_driver_are_used_where_a_clock_gave_them() -> None:
    clock = DriverClock(wall_s=lambda: 1.7e9)
    assert clock.taken_s(99.97, 100.0) == 99.97
    assert clock.kind == "the driver"
    assert clock.taken_s(1.7e9 - 0.02, 100.05) == pytest.approx(100.03)
    assert clock.kind == "the driver, by the time of day"
    for driver_s in (0.0, 12.0, 200.0):  # none, another clock's, the future
        assert clock.taken_s(driver_s, 100.1) == pytest.approx(100.1, abs=1e-3)
        assert clock.kind == "the time of arrival"


def test_a_picture_that_waited_in_a_buffer_is_as_old_as_its_stamp() -> None:
    clock = DriverClock()
    clock.taken_s(99.97, 100.0)
    assert clock.taken_s(100.0, 130.0) == 100.0
    clock.begin()
    assert clock.taken_s(101.0, 130.1) == 130.1


def test_stamps_increase_and_a_repeated_buffer_is_noticed() -> None:
    clock = DriverClock()
    first = clock.taken_s(99.9, 100.0)
    assert clock.is_repeated(99.9)
    assert not clock.is_repeated(99.95)
    assert clock.taken_s(99.8, 100.01) > first
    clock.taken_s(0.0, 100.02)
    assert not clock.is_repeated(0.0)


def test_what_does_not_return_is_left_behind() -> None:
    goes_on = threading.Event()
    with pytest.raises(TimeoutError):
        interruptible(lambda: goes_on.wait(PATIENCE_S), 0.01)
    goes_on.set()


def test_what_others_write_while_a_camera_reads_is_not_lost(capfd: pytest.CaptureFixture[str]) -> None:
    def read() -> None:
        quiet_beside()
        with quiet():
            os.write(2, b"written")

    thread = threading.Thread(target=read)
    thread.start()
    thread.join()
    with quiet():
        os.write(2, b"hidden")
    assert capfd.readouterr().err == "written"
