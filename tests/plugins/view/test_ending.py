"""How a run ended is drawn with what its log has of the end."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from graphnav_view import graphnav_draw_end, style

from graphnav.core.record import Recording

Record = Callable[..., Recording]


def shown(file: Path) -> npt.NDArray[Any]:
    """Return the picture, RGB."""
    pixels = cv2.imread(str(file))
    assert pixels is not None
    return np.asarray(pixels[..., ::-1], np.uint8)


def marked(file: Path) -> bool:
    """Return whether the picture has a cross of a contact."""
    return bool((np.abs(shown(file).astype(int) - style.rgb(style.CONTACT)).max(axis=-1) < 12).sum() > 30)


def test_a_contact_is_marked_on_the_map_beside_the_panels(record: Record, tmp_path: Path) -> None:
    file = tmp_path / "end.png"
    assert graphnav_draw_end(record(frames=20, contact=True), file) == file
    assert marked(file)
    assert shown(file).shape[1] > 1000


def test_a_drive_without_contact_has_no_cross(record: Record, tmp_path: Path) -> None:
    assert graphnav_draw_end(record(frames=20, at_goal=True), tmp_path / "end.png")
    assert not marked(tmp_path / "end.png")


def test_a_log_of_small_messages_gives_the_map_alone(record: Record, tmp_path: Path) -> None:
    large = ("robot.image", "flow.flow", "plane.plane", "steer.potential")
    assert graphnav_draw_end(record(frames=20), tmp_path / "all.png")
    assert graphnav_draw_end(record(frames=20, without=large), tmp_path / "small.png")
    assert shown(tmp_path / "small.png").shape[1] < shown(tmp_path / "all.png").shape[1]


def test_an_open_loop_gives_the_panels_alone(record: Record, tmp_path: Path) -> None:
    assert graphnav_draw_end(record(frames=4, without=("robot.map", "robot.state")), tmp_path / "end.png")


def test_a_log_that_says_nothing_draws_nothing(record: Record, tmp_path: Path) -> None:
    channels = ("robot.map", "robot.image", "robot.state", "flow.flow", "plane.plane")
    recording = record(frames=4, without=(*channels, "steer.steering", "steer.potential"))
    assert graphnav_draw_end(recording, tmp_path / "end.png") is None
    assert not (tmp_path / "end.png").exists()
