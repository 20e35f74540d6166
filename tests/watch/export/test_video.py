"""An mp4 plays to its end and has a frame for every picture."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from graphnav import Image, Twist
from graphnav.arrays import Bytes
from graphnav.core.cli import main
from graphnav.core.codec import encode
from graphnav.core.record import LogWriter, Recording


def read(path: Path) -> tuple[list[Bytes], float]:
    """Return the frames of a video, red-green-blue, and their rate."""
    capture = cv2.VideoCapture(str(path))
    frames = []
    while (got := capture.read())[0]:
        frames.append(np.asarray(got[1][..., ::-1], np.uint8))
    return frames, capture.get(cv2.CAP_PROP_FPS)


def test_the_panels_are_those_of_run_video(drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", str(drive), "--to", "mp4", "-o", str(tmp_path / "a.mp4")]) == 0
    assert capsys.readouterr().out.startswith(f"{tmp_path / 'a.mp4'}: 21 frames, ")
    assert main(["figure", str(drive), "--video", "-o", str(tmp_path)]) == 0
    frames, rate_hz = read(tmp_path / "a.mp4")
    others, _ = read(tmp_path / "video.mp4")
    with Recording(drive / "run.lcmlog") as recording:
        assert len(frames) == len(others) == recording.count("robot.image")
    assert rate_hz == pytest.approx(10.0)
    differences = [np.abs(one.astype(int) - other).mean() for one, other in zip(frames, others, strict=True)]
    assert max(differences) < 1.0  # libx264 does not always give the same bytes for the same frames


def test_a_span_of_panels_shows_the_path_from_the_beginning(drive: Path, tmp_path: Path) -> None:
    assert main(["export", str(drive), "--to", "mp4", "-o", str(tmp_path / "all.mp4")]) == 0
    words = ["--from", "1s", "--until", "1.5s"]
    assert main(["export", str(drive), "--to", "mp4", "-o", str(tmp_path / "some"), *words]) == 0
    frames, _ = read(tmp_path / "all.mp4")
    some, _ = read(tmp_path / "some")
    assert len(some) == 6
    differences = [np.abs(one.astype(int) - other).mean() for one, other in zip(frames[10:16], some, strict=True)]
    assert max(differences) < 2.5  # the encoder's own; a frame later it is 4 and more


@pytest.mark.parametrize("channel", ["robot.image", "flow.flow", "plane.plane", "steer.potential", "robot.state"])
def test_one_channel_has_a_frame_for_each_message(drive: Path, tmp_path: Path, channel: str) -> None:
    target = tmp_path / "a.mp4"
    assert main(["export", str(drive), "--to", "mp4", "-o", str(target), "--channel", channel]) == 0
    frames, rate_hz = read(target)
    with Recording(drive / "run.lcmlog") as recording:
        assert len(frames) == recording.count(channel)
    assert rate_hz == pytest.approx(10.0)
    assert max(frames[0].shape[:2]) >= 480
    assert not any(side % 2 for side in frames[0].shape[:2])
    assert frames[-1].std() > 5


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ["--channel", "control.twist"],
            (
                "channel 'control.twist' holds no messages with pictures\n"
                "  select a channel of images, flow, planes or states, or omit --channel for the panels\n"
            ),
        ),
        (
            ["--channel", "control.*"],
            (
                "a video shows one channel, or the panels\n"
                "  select one channel with --channel, or omit --channel for the panels\n"
            ),
        ),
        (
            [],
            (
                "{log} holds no images to make a video of\n"
                "  record them: run: {record: all}; or select another channel with --channel\n"
            ),
        ),
    ],
)
def test_what_has_no_picture_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str], said: str
) -> None:
    with LogWriter(tmp_path / "log") as log:
        log.write("control.twist", 5, encode(Twist(v_mps=0.0, omega_radps=1.0), 5, 0))
    assert main(["export", str(tmp_path / "log"), "--to", "mp4", "-o", str(tmp_path / "a.mp4"), *words]) == 2
    assert capsys.readouterr().err == said.replace("{log}", str(tmp_path / "log"))
    assert [path.name for path in tmp_path.iterdir()] == ["log"]


@pytest.mark.parametrize(
    ("shape", "frame", "said"),
    [
        ((2160, 3840), (1080, 1920), " of 1920x1080, reduced from 3840x2160"),
        ((601, 801), (602, 802), ""),
        ((1080, 1920), (1080, 1920), ""),
    ],
)
def test_a_camera_keeps_its_size_up_to_full_hd(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    shape: tuple[int, int],
    frame: tuple[int, int],
    said: str,
) -> None:
    target = tmp_path / "a.mp4"
    with LogWriter(tmp_path / "log") as log:
        for k in range(2):
            log.write("cam", 100_000 * k, encode(Image(np.full((*shape, 3), 99, np.uint8)), 100_000 * k, k))
    assert main(["export", str(tmp_path / "log"), "--to", "mp4", "-o", str(target), "--channel", "cam"]) == 0
    assert capsys.readouterr().out.startswith(f"{target}: 2 frames{said}, ")
    assert read(target)[0][0].shape[:2] == frame
