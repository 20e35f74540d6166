"""Pictures are undistorted by what the driver of the camera says, as `io.prepare` does by a file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from graphnav_io.calibration import calibration_text
from graphnav_io.lens import Lens
from graphnav_io.prepare import Prepare
from graphnav_io.undistort import Undistort

from graphnav import CameraInfo, Image, Latest
from graphnav.arrays import Bytes

ROWS, COLS = 48, 64
CAMERA = np.array([[50.0, 0.0, 31.0], [0.0, 52.0, 25.0], [0.0, 0.0, 1.0]])
LEVEL = np.array([[40.0, 0.0, 31.5], [0.0, 40.0, 23.5], [0.0, 0.0, 1.0]])
PINHOLE = np.array([-0.2, 0.05, 0.001, -0.002, 0.0])
FISHEYE = np.array([0.05, -0.01, 0.002, 0.0])
TURN = cv2.Rodrigues(np.array([0.01, -0.02, 0.1]))[0]
INFO = CameraInfo(ROWS, COLS, "plumb_bob", CAMERA, PINHOLE, TURN, np.column_stack([LEVEL, np.zeros(3)]))


def picture() -> Bytes:
    y, x = np.mgrid[:ROWS, :COLS]
    return np.asarray(120 + 60 * np.sin(x / 9) + 50 * np.cos(y / 7 + x / 23), np.uint8)


def stage_with(*, rectify: bool = False) -> Undistort:
    stage = Undistort(rectify=rectify)
    stage.reset(0)
    return stage


@pytest.mark.parametrize("rectify", [False, True])
@pytest.mark.parametrize("is_fisheye", [False, True])
def test_it_is_what_prepare_makes_by_a_file(tmp_path: Path, rectify: bool, is_fisheye: bool) -> None:
    distortion = FISHEYE if is_fisheye else PINHOLE
    file = tmp_path / "camera.yml"
    file.write_text(calibration_text(Lens(CAMERA, distortion, is_fisheye), ROWS, COLS, TURN, LEVEL))
    by_file = Prepare(calibration=file, rectify=rectify)
    by_file.reset(0)
    info = replace(INFO, model="equidistant" if is_fisheye else "plumb_bob", distortion=distortion)
    found = stage_with(rectify=rectify).step(Image(pixels=picture()), Latest(info, 0.1))
    assert found is not None
    wanted = by_file.step(Image(pixels=picture())).pixels
    assert np.abs(found.pixels.astype(int) - wanted).max() <= 1, "the file has ten digits"
    assert (found.pixels != picture()).any()


def test_nothing_is_published_before_the_camera_is_known() -> None:
    stage = stage_with()
    assert stage.step(Image(pixels=picture()), Latest()) is None
    assert stage.step(Image(pixels=picture()), Latest(INFO, 0.1)) is not None


def test_other_information_makes_other_maps_and_the_same_does_not() -> None:
    stage = stage_with()
    first = stage.step(Image(pixels=picture()), Latest(INFO, 0.1))
    maps = stage._maps
    again = stage.step(Image(pixels=picture()), Latest(replace(INFO, camera=CAMERA.copy()), 0.1))
    assert stage._maps is maps
    straight = stage.step(Image(pixels=picture()), Latest(replace(INFO, distortion=np.zeros(0)), 0.1))
    assert first is not None
    assert again is not None
    assert straight is not None
    np.testing.assert_array_equal(first.pixels, again.pixels)
    np.testing.assert_array_equal(straight.pixels, picture())


def test_what_does_not_fit_is_told() -> None:
    with pytest.raises(ValueError, match=r"^a picture has 64x48 pixels, but its camera's information is of 640x480: "):
        stage_with().step(Image(pixels=picture()), Latest(replace(INFO, rows=480, cols=640), 0.1))
    for wrong in (replace(INFO, projection=np.zeros((3, 4))), replace(INFO, rectification=np.zeros((3, 3)))):
        with pytest.raises(ValueError, match="has no projection, or a rectification that is not a rotation"):
            stage_with(rectify=True).step(Image(pixels=picture()), Latest(wrong, 0.1))
        assert stage_with().step(Image(pixels=picture()), Latest(wrong, 0.1)) is not None
