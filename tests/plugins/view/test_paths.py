"""Several paths through one world are drawn over its map."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from graphnav_view import graphnav_draw_paths, style

from graphnav.core.record import Recording

from .conftest import Drive, write_log

COLOURS = {"one": "#2563a8", "two": "#b4501e"}
WALL, OBSTACLE = "#4c566a", "#c98a4b"


def drives(folder: Path, **options: Drive) -> dict[str, Recording]:
    """Return made-up drives, read."""
    return {name: Recording(write_log(folder / f"{name}.lcmlog", drive)) for name, drive in options.items()}


def has(file: Path, colour: str) -> bool:
    """Return whether a picture has a colour."""
    pixels = cv2.imread(str(file))
    assert pixels is not None
    return bool((np.abs(pixels[..., ::-1].astype(int) - style.rgb(colour)).max(axis=-1) < 6).sum() > 20)


def test_each_path_has_its_colour(tmp_path: Path) -> None:
    found = drives(tmp_path, one=Drive(frames=40), two=Drive(frames=15, contact=True))
    file = tmp_path / "paths.png"
    assert graphnav_draw_paths(found, COLOURS, file) == file
    assert all(has(file, colour) for colour in (*COLOURS.values(), WALL, OBSTACLE))


def test_the_same_logs_give_the_same_bytes(tmp_path: Path) -> None:
    found = drives(tmp_path, one=Drive(frames=9, moving=True), two=Drive(frames=5, moving=True))
    for name in ("a.png", "b.png"):
        assert graphnav_draw_paths(found, COLOURS, tmp_path / name)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


@pytest.mark.parametrize("missing", ["robot.map", "robot.state"])
def test_logs_without_a_map_or_states_draw_nothing(tmp_path: Path, missing: str) -> None:
    found = drives(tmp_path, one=Drive(frames=3, without=(missing,)))
    assert graphnav_draw_paths(found, COLOURS, tmp_path / "paths.png") is None
    assert not (tmp_path / "paths.png").exists()
