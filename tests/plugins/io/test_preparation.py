"""Pictures are undistorted, rotated, cropped and resized, in this order; what cannot be done is reported."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from graphnav_io.images import Images
from graphnav_io.prepare import Prepare
from graphnav_io.video import Video

from graphnav import Image, ParamError, Source
from graphnav.arrays import Bytes, Doubles

Play = Callable[[Source], list[Image]]

ROWS, COLS = 48, 64
CAMERA = np.array([[50.0, 0.0, 31.0], [0.0, 52.0, 25.0], [0.0, 0.0, 1.0]])
PINHOLE = np.array([-0.2, 0.05, 0.001, -0.002, 0.0])
FISHEYE = np.array([0.05, -0.01, 0.002, 0.0])


def picture(rows: int = ROWS, cols: int = COLS) -> Bytes:
    """Return a smooth gray picture without symmetry."""
    y, x = np.mgrid[:rows, :cols]
    return np.asarray(120 + 60 * np.sin(x / 9) + 50 * np.cos(y / 7 + x / 23), np.uint8)


def prepared(pixels: Bytes, **parameters: Any) -> Bytes:
    stage = Prepare(**parameters)
    stage.check()
    stage.reset(0)
    return stage.step(Image(pixels=pixels)).pixels


@pytest.fixture
def calibrate(tmp_path: Path) -> Callable[..., Path]:
    """Return a function that writes a calibration as cv2.FileStorage does."""

    def write(distortion: Doubles = PINHOLE, **others: Any) -> Path:
        path = tmp_path / "camera.yaml"
        file = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
        known: dict[str, Any] = {
            "image_width": COLS,
            "image_height": ROWS,
            "camera_matrix": CAMERA,
            "distortion_coefficients": distortion.reshape(1, -1),
            **others,
        }
        for key, value in known.items():
            if value is not None:
                file.write(key, value)
        file.release()
        return path

    return write


def test_nothing_asked_for_changes_nothing() -> None:
    assert np.array_equal(prepared(picture()), picture())


@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("turns", [0, 1, 2, 3])
def test_rotation_is_counterclockwise_and_exact(turns: int, channels: int) -> None:
    pixels = np.squeeze(np.stack([picture(), picture()[::-1], picture()[:, ::-1]][:channels], axis=-1))
    assert np.array_equal(prepared(pixels, rotate_deg=90 * turns), np.rot90(pixels, turns))


def test_a_camera_upside_down_is_turned_upright_twice_over() -> None:
    assert np.array_equal(prepared(prepared(picture(), rotate_deg=180), rotate_deg=180), picture())


@pytest.mark.parametrize("box", [{"crop_px": (16, 12, 48, 36)}, {"crop_ratio": (0.25, 0.25, 0.75, 0.75)}])
def test_a_crop_keeps_its_box(box: dict[str, Any]) -> None:
    assert np.array_equal(prepared(picture(), **box), picture()[12:36, 16:48])


@pytest.mark.parametrize(("ratio", "top"), [(0.0, 0), (0.25, 12), (0.4, 19), (0.97, 47), (1e-6, 0)])
@pytest.mark.parametrize("channels", [1, 3])
def test_a_share_of_the_rows_is_cropped_at_the_top(ratio: float, top: int, channels: int) -> None:
    pixels = np.squeeze(np.stack([picture()] * channels, axis=-1))
    assert np.array_equal(prepared(pixels, crop_top_ratio=ratio), pixels[top:])


def test_the_top_is_that_of_the_rotated_and_undistorted_picture(calibrate: Callable[..., Path]) -> None:
    assert np.array_equal(prepared(picture(), rotate_deg=90, crop_top_ratio=0.5), np.rot90(picture())[32:])
    undistorted = prepared(picture(), calibration=calibrate())
    assert np.array_equal(prepared(picture(), calibration=calibrate(), crop_top_ratio=0.5), undistorted[24:])
    assert prepared(picture(), crop_top_ratio=0.5, size=(32, 12)).shape == (12, 32)


def test_a_crop_is_of_the_rotated_picture_and_a_size_of_the_cropped_one() -> None:
    rotated = np.rot90(picture())
    cropped = prepared(picture(), rotate_deg=90, crop_px=(0, 10, 40, 60))
    assert np.array_equal(cropped, rotated[10:60, 0:40])
    assert prepared(picture(), rotate_deg=90, crop_px=(0, 10, 40, 60), size=(20, 25)).shape == (25, 20)
    assert prepared(picture(), rotate_deg=90, crop_px=(0, 10, 40, 60), scale=0.5).shape == (25, 20)


def test_a_pinhole_camera_is_undistorted_as_opencv_does(calibrate: Callable[..., Path]) -> None:
    expected = cv2.undistort(picture(), CAMERA, PINHOLE)
    found = prepared(picture(), calibration=calibrate())
    # cv2.undistort rounds its maps to 1/32 pixel; the picture changes by at most 10 gray levels per pixel
    assert np.abs(found.astype(int) - expected).max() <= 1


@pytest.mark.parametrize("key", [{"distortion_model": "equidistant"}, {"fisheye_model": 1}])
def test_a_fisheye_is_undistorted_as_opencv_does(key: dict[str, Any], calibrate: Callable[..., Path]) -> None:
    expected = cv2.fisheye.undistortImage(picture(), CAMERA, FISHEYE, Knew=CAMERA)
    found = prepared(picture(), calibration=calibrate(FISHEYE, **key))
    assert np.abs(found.astype(int) - expected).max() <= 1


def test_undistortion_comes_before_rotation_and_crop(calibrate: Callable[..., Path]) -> None:
    path = calibrate()
    undistorted = prepared(picture(), calibration=path)
    found = prepared(picture(), calibration=path, rotate_deg=270, crop_px=(5, 6, 40, 50))
    assert np.array_equal(found, np.rot90(undistorted, 3)[6:50, 5:40])


def test_a_calibration_of_ros_is_read(tmp_path: Path, calibrate: Callable[..., Path]) -> None:
    path = tmp_path / "ros.yaml"
    camera, distortion = (", ".join(map(repr, values.ravel().tolist())) for values in (CAMERA, PINHOLE))
    path.write_text(
        f"image_width: {COLS}\nimage_height: {ROWS}\ncamera_name: front\n"
        f"camera_matrix:\n  rows: 3\n  cols: 3\n  data: [{camera}]\n"
        f"distortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [{distortion}]\n"
    )
    assert np.array_equal(prepared(picture(), calibration=path), prepared(picture(), calibration=calibrate()))


def test_without_distortion_nothing_changes(calibrate: Callable[..., Path]) -> None:
    assert np.array_equal(prepared(picture(), calibration=calibrate(np.zeros(4))), picture())


@pytest.mark.parametrize("source", [Images, Video])
def test_sources_prepare_as_the_stage_does(
    source: Any, tmp_path: Path, calibrate: Callable[..., Path], play: Play
) -> None:
    file = tmp_path / "a.png"
    cv2.imwrite(str(file), picture())
    words = {"calibration": calibrate(), "rotate_deg": 180, "crop_ratio": (0.0, 0.5, 1.0, 1.0), "size": (32, 12)}
    (image,) = play(source(path=tmp_path / "*.png", **words))
    assert np.array_equal(image.pixels, prepared(picture(), **words))


def refusal(**parameters: Any) -> ParamError:
    with pytest.raises(ExceptionGroup) as raised:
        Prepare(**parameters).check()
    (error,) = raised.value.exceptions
    assert isinstance(error, ParamError)
    assert error.hint
    return error


def test_two_crops_are_refused() -> None:
    error = refusal(crop_px=(0, 0, 1, 1), crop_ratio=(0.0, 0.0, 1.0, 1.0))
    assert (error.param, error.what) == ("crop_px", "'crop_px' and 'crop_ratio' are both given")


@pytest.mark.parametrize("crop", [{"crop_px": (0, 0, 1, 1)}, {"crop_ratio": (0.0, 0.0, 1.0, 1.0)}])
def test_a_crop_of_the_top_and_another_are_refused(crop: dict[str, Any]) -> None:
    (name,) = crop
    error = refusal(crop_top_ratio=0.4, **crop)
    assert (error.param, error.what) == ("crop_top_ratio", f"'crop_top_ratio' is 0.4, but '{name}' is given too")
    assert prepared(picture(), crop_top_ratio=0.0, **crop).size


def test_an_empty_crop_is_refused() -> None:
    error = refusal(crop_ratio=(0.5, 0.5, 0.5, 1.0))
    assert (error.param, error.what) == ("crop_ratio", "'crop_ratio' is [0.5, 0.5, 0.5, 1.0], which is empty")
    assert refusal(crop_px=(9, 0, 5, 1)).what == "'crop_px' is [9, 0, 5, 1], which is empty"


FAULTS: dict[str, tuple[dict[str, Any], str]] = {
    "matrix": ({"camera_matrix": None}, "it has no 'camera_matrix'"),
    "coefficients": ({"distortion_coefficients": None}, "it has no 'distortion_coefficients'"),
    "size": ({"image_width": None}, "it has no 'image_width'"),
    "shape": ({"camera_matrix": np.eye(2)}, "'camera_matrix' is not a 3x3 matrix with positive focal lengths"),
    "focal": ({"camera_matrix": -np.eye(3)}, "'camera_matrix' is not a 3x3 matrix with positive focal lengths"),
    "number": ({"camera_matrix": "front"}, "'camera_matrix' does not hold a list of finite numbers"),
    "nan": ({"camera_matrix": np.full((3, 3), np.nan)}, "'camera_matrix' does not hold a list of finite numbers"),
    "pixels": ({"image_height": 0}, "'image_height' is not a number of pixels"),
    "model": ({"distortion_model": "lense"}, "the distortion model 'lense' is not known"),
    "count": (
        {"distortion_model": "equidistant"},
        "'distortion_coefficients' has 5 numbers, but a fisheye camera has 4",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_calibration_that_lacks_something_is_refused(name: str, calibrate: Callable[..., Path]) -> None:
    changes, what = FAULTS[name]
    path = calibrate(**changes)
    error = refusal(calibration=path)
    assert (error.param, error.what) == ("calibration", f"'{path}': {what}")


@pytest.mark.parametrize(
    ("content", "what"),
    [
        (b"\xff\xfe\x00", "it is not a text file"),
        (b"a: [1, 2", "OpenCV cannot read it as YAML"),
        (b"", "OpenCV cannot read it as YAML"),
        (b"- 1\n- 2\n", "it holds no calibration"),
    ],
)
def test_a_file_that_is_no_calibration_is_refused(
    content: bytes, what: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "camera.yaml"
    path.write_bytes(content)
    assert refusal(calibration=path).what == f"'{path}': {what}"
    assert capfd.readouterr() == ("", "")


def test_a_missing_calibration_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "lost.yaml"
    assert refusal(calibration=path).what == f"'{path}' cannot be read: No such file or directory"


@pytest.mark.parametrize("source", [Images, Video])
def test_sources_compare_the_first_picture_before_the_run(
    source: Any, folder: Path, calibrate: Callable[..., Path]
) -> None:
    for parameters, param in (
        ({"calibration": calibrate(image_width=640, image_height=480)}, "calibration"),
        ({"crop_px": (0, 0, COLS + 1, ROWS)}, "crop_px"),
        ({"crop_ratio": (0.0, 0.0, 0.001, 1.0)}, "crop_ratio"),
        ({"crop_top_ratio": 0.999}, "crop_top_ratio"),
    ):
        with pytest.raises(ParamError) as raised:
            source(path=folder, **parameters).check()
        assert raised.value.param == param
        assert raised.value.hint


def test_a_live_camera_of_another_size_ends_the_run_with_one_line(calibrate: Callable[..., Path]) -> None:
    path = calibrate()
    with pytest.raises(ValueError, match=r"is of pictures of 64x48 pixels, but the camera's are 32x24; calibrate at"):
        prepared(picture(24, 32), calibration=path)
    with pytest.raises(ValueError, match=r"'crop_px' is \[0, 0, 64, 48\], but the rotated picture has 32 columns"):
        prepared(picture(24, 32), crop_px=(0, 0, 64, 48))
