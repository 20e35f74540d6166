"""Pictures depend on the log alone, and the same log gives the same bytes."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import cv2
import matplotlib as mpl
import numpy as np
import pytest
from graphnav_view import graphnav_draw, graphnav_draw_end, graphnav_draw_frames, style
from graphnav_view.signals import Signals
from graphnav_view.track import track_of

from graphnav.core.record import Recording

Record = Callable[..., Recording]


def drawn(recording: Recording, folder: Path, *, video: bool = False) -> list[str]:
    folder.mkdir()
    paths = graphnav_draw(recording, folder, video, ".png")
    assert sorted(folder.iterdir()) == sorted(paths)
    return [path.name for path in paths]


def share_of(colour: str, path: Path) -> float:
    """Return the share of a picture's pixels that have a colour."""
    pixels = cv2.imread(str(path))
    assert pixels is not None
    return float((np.abs(pixels[..., ::-1].astype(int) - style.rgb(colour)).max(axis=-1) < 12).mean())


def test_a_drive_gives_a_map_and_panels(record: Record, tmp_path: Path) -> None:
    assert drawn(record(moving=True, at_goal=True), tmp_path / "out") == ["map.png", "panels.png"]


def test_the_same_log_gives_the_same_bytes_whatever_the_user_has_set(record: Record, tmp_path: Path) -> None:
    recording = record(frames=12)
    drawn(recording, tmp_path / "first")
    with mpl.rc_context({"font.size": 20, "axes.facecolor": "red", "savefig.dpi": 40, "text.usetex": False}):
        drawn(recording, tmp_path / "second")
        assert mpl.rcParams["font.size"] == 20
    for name in ("map.png", "panels.png"):
        first, second = (tmp_path / folder / name for folder in ("first", "second"))
        assert first.read_bytes() == second.read_bytes()
        assert b"matplotlib" not in first.read_bytes()


def test_only_a_contact_is_marked(record: Record, tmp_path: Path) -> None:
    drawn(record(frames=12), tmp_path / "free")
    drawn(record(frames=12, contact=True), tmp_path / "hit")
    assert share_of(style.CONTACT, tmp_path / "free" / "map.png") == 0
    assert share_of(style.CONTACT, tmp_path / "hit" / "map.png") > 1e-4


def test_moving_obstacles_are_drawn_at_several_times(record: Record, tmp_path: Path) -> None:
    drawn(record(frames=80), tmp_path / "still")
    drawn(record(frames=80, moving=True), tmp_path / "moving")
    still, moving = (cv2.imread(str(tmp_path / name / "map.png")) for name in ("still", "moving"))
    assert still is not None
    assert moving is not None
    assert still.shape == moving.shape
    inside = np.abs(still.astype(int) - moving.astype(int)).max(axis=-1)[100:-120] > 0
    count, _ = cv2.connectedComponents(inside.astype(np.uint8), connectivity=8)
    assert count - 1 >= 3


def test_an_open_loop_gives_panels_but_no_map(record: Record, tmp_path: Path) -> None:
    recording = record(without=("robot.map", "robot.state", "control.twist"))
    assert drawn(recording, tmp_path / "out", video=True) == ["panels.png", "video.mp4"]


@pytest.mark.parametrize(
    "missing", ["robot.image", "flow.flow", "plane.plane", "steer.potential", "steer.steering", "robot.map"]
)
def test_panels_do_without_what_the_log_lacks(record: Record, tmp_path: Path, missing: str) -> None:
    assert "panels.png" in drawn(record(frames=6, without=(missing,)), tmp_path / "out")


def test_a_log_of_small_messages_gives_a_map_only(record: Record, tmp_path: Path) -> None:
    large = ("robot.image", "flow.flow", "plane.plane", "steer.potential")
    assert drawn(record(frames=6, without=large), tmp_path / "out") == ["map.png"]


def test_what_a_logger_caught_of_the_tap_is_drawn(record: Record, tmp_path: Path) -> None:
    """Thinned grids, and a log that does not begin with what made it."""
    caught = record(frames=8, step_px=3, about=False)
    assert drawn(caught, tmp_path / "out", video=True) == ["map.png", "panels.png", "video.mp4"]


def test_a_run_of_one_frame_is_drawn(record: Record, tmp_path: Path) -> None:
    assert drawn(record(frames=1), tmp_path / "out", video=True) == ["map.png", "panels.png", "video.mp4"]


def test_loading_the_family_loads_no_drawing_library() -> None:
    code = "import graphnav_view, sys; print(sorted({'matplotlib', 'cv2', 'sklearn'} & set(sys.modules)))"
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert told.stdout.strip() == "[]"


def test_a_pose_that_is_not_finite_is_left_out(record: Record, tmp_path: Path) -> None:
    recording = record(frames=6, lost=(2, 5), moving=True)
    track = track_of(Signals(recording))
    assert track is not None
    assert track.time_s.tolist() == [0.0, 0.1, 0.3, 0.4]
    assert np.isfinite(track.pose).all()
    assert drawn(recording, tmp_path / "out", video=True) == ["map.png", "panels.png", "video.mp4"]
    assert graphnav_draw_frames(recording, [0.2, 0.5], tmp_path, ".png")
    assert graphnav_draw_end(recording, tmp_path / "end.png")


def test_without_a_finite_pose_there_is_no_map(record: Record, tmp_path: Path) -> None:
    recording = record(frames=3, lost=(0, 1, 2))
    assert track_of(Signals(recording)) is None
    assert drawn(recording, tmp_path / "out", video=True) == ["panels.png", "video.mp4"]
