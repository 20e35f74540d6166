"""Videos become images; errors are reported in one line."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from graphnav_io.quiet import quiet
from graphnav_io.video import Video

from graphnav import Image, ParamError, Source

Play = Callable[[Source], list[Image]]
WriteVideo = Callable[..., Path]


@pytest.mark.parametrize(("name", "codec"), [("a.mp4", "mp4v"), ("a.avi", "MJPG")])
def test_every_frame_comes_once_and_in_order(name: str, codec: str, write_video: WriteVideo, play: Play) -> None:
    images = play(Video(path=write_video(name, codec)))
    numbers = [image.pixels[:, :24].mean() / 8 for image in images]
    assert numbers == pytest.approx(list(range(30)), abs=0.5)
    red = images[0].pixels[:, 40:].reshape(-1, 3).mean(axis=0)
    assert red == pytest.approx([200, 0, 0], abs=15)


@pytest.mark.parametrize("rate_hz", [12.5, 20.0, 60.0])
def test_the_rate_is_the_files_unless_told_otherwise(rate_hz: float, write_video: WriteVideo) -> None:
    path = write_video(rate_hz=rate_hz)
    for given, expected in ((0.0, rate_hz), (7.0, 7.0)):
        source = Video(path=path, rate_hz=given)
        source.reset(0)
        assert source.rate() == pytest.approx(expected)
        source.close()


def test_size_and_gray_hold_for_videos(write_video: WriteVideo, play: Play) -> None:
    images = play(Video(path=write_video(), size=(32, 24), gray=True))
    assert {image.pixels.shape for image in images} == {(24, 32)}


def test_a_reset_begins_again(write_video: WriteVideo, play: Play) -> None:
    source = Video(path=write_video(frames=5))
    first, second = play(source), play(source)
    assert len(first) == len(second) == 5
    assert all(np.array_equal(a.pixels, b.pixels) for a, b in zip(first, second, strict=True))


def test_close_may_come_before_reset_and_twice(write_video: WriteVideo) -> None:
    source = Video(path=write_video())
    source.close()
    source.reset(0)
    source.close()
    source.close()


CANNOT_READ = "is not a complete video that OpenCV can read"


@pytest.mark.parametrize(
    ("content", "what"),
    [
        (b"", "is empty"),
        (b"no video" * 1000, CANNOT_READ),
        (bytes(5000), CANNOT_READ),
        (np.random.default_rng(0).bytes(5000), CANNOT_READ),
    ],
)
@pytest.mark.parametrize("name", ["a.mp4", "a.avi", "a.txt"])
def test_what_is_no_video_is_refused_in_one_line(
    content: bytes, what: str, name: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(ParamError) as raised:
        Video(path=path).check()
    assert (raised.value.param, raised.value.what) == ("path", f"'{path}' {what}")
    assert capfd.readouterr() == ("", "")


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ParamError) as raised:
        Video(path=tmp_path / "lost.mp4").check()
    assert raised.value.what == f"there is no file '{tmp_path}/lost.mp4'"


@pytest.mark.parametrize("path", ["97", "/dev/video97"])
def test_a_missing_camera_is_refused(path: str, capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ParamError) as raised:
        Video(path=Path(path)).check()
    assert (raised.value.what, str(raised.value.hint)[:16]) == (f"there is no camera {path}", "this machine has")
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("path", ["/dev/null", "/dev/../dev/zero"])
def test_another_device_is_not_a_camera(path: str) -> None:
    for read in (Video(path=Path(path)).check, lambda: Video(path=Path(path)).reset(seed=0)):
        with pytest.raises(ParamError, match=f"{path} is not a camera"):
            read()


def test_check_does_not_open_a_camera(monkeypatch: pytest.MonkeyPatch) -> None:
    device = os.stat_result((stat.S_IFCHR | 0o666, *[0] * 9), {"st_rdev": os.makedev(81, 0)})
    monkeypatch.setattr(Path, "stat", lambda *_, **__: device)
    monkeypatch.setattr(os, "access", lambda *_: True)
    opened: list[object] = []
    closed = cv2.VideoCapture()

    def capture(*source: object) -> cv2.VideoCapture:
        opened.append(source)
        return closed

    monkeypatch.setattr(cv2, "VideoCapture", capture)
    Video(path=Path("/dev/video0")).check()
    assert opened == []
    with pytest.raises(ParamError, match="camera /dev/video0 cannot be opened"):
        Video(path=Path("/dev/video0")).reset(seed=0)
    assert opened == [("/dev/video0", cv2.CAP_V4L2)]


def test_a_dead_stream_is_refused(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ParamError) as raised:
        Video(path=Path("http://127.0.0.1:9/drive.mp4")).reset(seed=0)
    assert raised.value.what == "the stream 'http://127.0.0.1:9/drive.mp4' cannot be opened"
    assert capfd.readouterr() == ("", "")


def test_a_file_without_its_index_is_refused_before_the_run(write_video: WriteVideo) -> None:
    path = write_video()
    path.write_bytes(path.read_bytes()[:-400])
    with pytest.raises(ParamError) as raised:
        Video(path=path).check()
    assert raised.value.what == f"'{path}' {CANNOT_READ}"


def test_a_file_that_was_cut_off_plays_what_is_there_then_says_so(
    write_video: WriteVideo, capfd: pytest.CaptureFixture[str]
) -> None:
    path = write_video("a.avi", "MJPG")
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    source = Video(path=path)
    source.check()
    source.reset(0)
    played: list[Image] = []
    with pytest.raises(ValueError, match=r"ends after \d+ of 30 frames") as raised:
        played.extend(source.step() for _ in range(30))
    source.close()
    assert 0 < len(played) < 25
    assert str(raised.value) == f"'{path}' ends after {len(played)} of 30 frames: it is truncated"
    assert capfd.readouterr() == ("", "")


def test_quiet_hides_only_what_is_written_meanwhile(capfd: pytest.CaptureFixture[str]) -> None:
    os.write(2, b"before ")
    with quiet():
        os.write(2, b"hidden")
    os.write(2, b"after")
    assert capfd.readouterr().err == "before after"
