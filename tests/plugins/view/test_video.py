"""The video shows every frame at the camera's rate."""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from graphnav_view import graphnav_draw, style
from graphnav_view.signals import Signals
from graphnav_view.video.mp4 import write_frames
from graphnav_view.video.video_frames import caption, video_frames

from graphnav import Flow, Image, Plane, Potential, State, Steering, Twist, UserError
from graphnav.arrays import Bools, Bytes
from graphnav.core.record import Recording

Record = Callable[..., Recording]


def read(path: Path) -> tuple[list[Bytes], float]:
    """Return a video's frames, red-green-blue, and their rate."""
    capture = cv2.VideoCapture(str(path))
    frames = []
    while (got := capture.read())[0]:
        frames.append(np.asarray(got[1][..., ::-1], np.uint8))
    return frames, capture.get(cv2.CAP_PROP_FPS)


def write_video(recording: Recording, path: Path) -> Path:
    video = video_frames(Signals(recording))
    assert video is not None
    return write_frames(video, path)


def near(frame: Bytes, colour: str) -> Bools:
    return np.asarray(np.abs(frame.astype(int) - style.rgb(colour)).max(axis=-1) < 40)


def test_it_has_every_frame_at_the_camera_s_rate(record: Record, tmp_path: Path) -> None:
    path = write_video(record(frames=12), tmp_path / "video.mp4")
    assert cv2.VideoCapture(str(path)).get(cv2.CAP_PROP_FOURCC) == cv2.VideoWriter.fourcc(*"h264"), "browsers play it"
    frames, rate_hz = read(path)
    assert len(frames) == 12
    assert rate_hz == pytest.approx(10.0)
    rows, cols = frames[0].shape[:2]
    assert (rows % 2, cols % 2) == (0, 0)
    assert cols >= 960
    assert rows >= 720


def test_the_robot_moves_on_the_map(record: Record, tmp_path: Path) -> None:
    frames, _ = read(write_video(record(frames=40), tmp_path / "video.mp4"))
    ink_of = [near(frame[frame.shape[0] // 2 + 10 : -40, frame.shape[1] // 2 :], style.ROBOT).sum() for frame in frames]
    assert ink_of[-1] > 1.5 * ink_of[1]


def test_obstacle_is_red_on_the_side_where_it_is(record: Record, tmp_path: Path) -> None:
    """Frame 10 of the made-up drive has the outer wall on its right."""
    frames, _ = read(write_video(record(frames=12), tmp_path / "video.mp4"))
    rows, cols = frames[10].shape[:2]
    tile = frames[10][rows // 2 + 10 : -50, : cols // 2].astype(int)
    red = (tile[..., 0] > tile[..., 1] + 60) & (tile[..., 0] > tile[..., 2] + 40)
    left, right = np.array_split(red, 2, axis=1)
    assert right.mean() > 3 * left.mean()
    assert right.mean() > 0.1


def test_an_open_loop_shows_the_potential_instead_of_the_map(record: Record, tmp_path: Path) -> None:
    without = ("robot.map", "robot.state", "control.twist")
    frames, _ = read(write_video(record(frames=5, without=without), tmp_path / "video.mp4"))
    assert frames[0].shape[1] >= 960


def test_a_log_without_images_says_what_to_record(record: Record, tmp_path: Path) -> None:
    with pytest.raises(UserError, match="does not contain images"):
        graphnav_draw(record(frames=3, without=("robot.image",)), tmp_path, True, ".png")


@pytest.mark.parametrize("has_pyav", [True, False])
def test_a_file_that_cannot_be_written_is_named(
    record: Record, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, has_pyav: bool
) -> None:
    if not has_pyav:
        monkeypatch.setattr("graphnav_view.video.mp4._pyav", lambda: None)
    with pytest.raises((UserError, OSError), match=r"absent|No such file"):
        write_video(record(frames=3), tmp_path / "absent" / "video.mp4")


def test_without_pyav_browsers_play_it_too(record: Record, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("graphnav_view.video.mp4._pyav", lambda: None)
    path = write_video(record(frames=2), tmp_path / "video.mp4")
    assert cv2.VideoCapture(str(path)).get(cv2.CAP_PROP_FOURCC) == cv2.VideoWriter.fourcc(*"VP90")


def test_a_caption_shows_no_minus_zero() -> None:
    nothing = np.zeros(2)
    steering = Steering(repulsive=nothing, guiding=nothing, control=nothing, theta_rad=-0.004, eigenvalues=nothing)
    of = dict.fromkeys((Image, Flow, Plane, Potential, State)) | {
        Steering: steering,
        Twist: Twist(v_mps=-0.001, omega_radps=-0.004),
    }
    assert caption(100_000, of) == ["t =   0.10 s", "theta =   +0 deg", "v = 0.00 m/s", "omega = +0.00 rad/s"]
