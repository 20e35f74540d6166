"""Folders of pictures become images; errors are reported in one line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from graphnav_io.images import Images
from graphnav_io.video import Video

from graphnav import Finished, Image, ParamError, Source

Play = Callable[[Source], list[Image]]


@pytest.mark.parametrize("source", [Images, Video])
def test_a_folder_plays_in_natural_order(source: Any, folder: Path, play: Play) -> None:
    images = play(source(path=folder))
    assert [int(image.pixels[0, 0, 0]) // 8 for image in images] == list(range(1, 13))


def test_colours_come_as_red_green_blue(folder: Path, play: Play) -> None:
    image = play(Images(path=folder))[0]
    assert image.pixels.shape == (48, 64, 3)
    assert image.pixels.dtype == np.uint8
    assert list(image.pixels[0, -1]) == [200, 0, 0]


def test_gray_pictures_stay_gray(tmp_path: Path, play: Play) -> None:
    cv2.imwrite(str(tmp_path / "a.png"), np.full((6, 8), 77, np.uint8))
    (image,) = play(Images(path=tmp_path))
    assert image.pixels.shape == (6, 8)
    assert (image.pixels == 77).all()


def test_gray_reduces_colours(folder: Path, play: Play) -> None:
    image = play(Images(path=folder, gray=True))[3]
    assert image.pixels.shape == (48, 64)
    assert image.pixels[0, 0] == 32


@pytest.mark.parametrize(("parameters", "shape"), [({"size": (20, 10)}, (10, 20)), ({"scale": 0.5}, (24, 32))])
def test_images_are_resized(parameters: dict[str, Any], shape: tuple[int, int], folder: Path, play: Play) -> None:
    assert {image.pixels.shape[:2] for image in play(Images(path=folder, **parameters))} == {shape}


def test_a_pattern_picks_pictures(folder: Path, play: Play) -> None:
    assert len(play(Images(path=folder / "frame_1*.png"))) == 4


def test_one_picture_is_a_sequence_of_one(folder: Path, play: Play) -> None:
    assert len(play(Images(path=folder / "frame_7.png"))) == 1


def test_the_last_picture_ends_the_run_and_comes_with_the_end(folder: Path) -> None:
    source = Images(path=folder / "frame_7.png")
    source.reset(0)
    with pytest.raises(Finished) as finished:
        source.step()
    assert finished.value.outcome == "end"
    assert finished.value.outputs.pixels[0, 0, 0] == 56


def test_a_reset_begins_again(folder: Path) -> None:
    source = Images(path=folder)
    for _ in range(2):
        source.reset(0)
        assert source.step().pixels[0, 0, 0] == 8


@pytest.mark.parametrize("source", [Images, Video])
def test_pictures_come_ten_a_second_unless_told_otherwise(source: Any, folder: Path) -> None:
    for parameters, rate_hz in (({}, 10.0), ({"rate_hz": 25.0}, 25.0)):
        stage = source(path=folder, **parameters)
        stage.reset(0)
        assert stage.rate() == rate_hz


def refusal(source: Source) -> str:
    with pytest.raises(ParamError) as raised:
        source.check()
    return str(raised.value.what)


@pytest.mark.parametrize("source", [Images, Video])
def test_a_folder_without_pictures_is_refused(source: Any, tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("no picture")
    assert refusal(source(path=tmp_path)) == f"there is no picture in '{tmp_path}'"


def test_a_missing_folder_is_refused(tmp_path: Path) -> None:
    assert refusal(Images(path=tmp_path / "lost")) == f"there is no folder '{tmp_path}/lost'"


@pytest.mark.parametrize("source", [Images, Video])
def test_a_pattern_without_a_match_is_refused(source: Any, tmp_path: Path) -> None:
    assert refusal(source(path=tmp_path / "*.jpg")) == f"no file matches '{tmp_path}/*.jpg'"


def test_a_size_beside_a_scale_is_refused(folder: Path) -> None:
    with pytest.raises(ExceptionGroup) as raised:
        Images(path=folder, size=(8, 6), scale=0.5, crop_ratio=(0.5, 0.0, 0.1, 1.0)).check()
    assert [error.param for error in raised.value.exceptions if isinstance(error, ParamError)] == [
        "scale",
        "crop_ratio",
    ]


def test_a_first_picture_that_is_none_is_refused_before_the_run(folder: Path) -> None:
    first = folder / "frame_1.png"
    first.write_text("no picture")
    assert refusal(Images(path=folder)) == f"'{first}' is not a picture that OpenCV can read"


BROKEN: dict[str, tuple[Callable[[bytes], bytes], str]] = {
    "text": (lambda _: b"no picture", "is not a picture that OpenCV can read"),
    "empty": (lambda _: b"", "is empty"),
    "cut": (lambda data: data[: len(data) // 2], "is truncated or damaged"),
    "garbled": (lambda data: data[:50] + bytes(20) + data[70:], "is not a picture that OpenCV can read"),
}


@pytest.mark.parametrize("source", [Images, Video])
@pytest.mark.parametrize("kind", BROKEN)
def test_a_broken_picture_in_the_middle_stops_with_one_line(
    source: Any, kind: str, folder: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    broken, (spoil, what) = folder / "frame_5.png", BROKEN[kind]
    broken.write_bytes(spoil(broken.read_bytes()))
    stage = source(path=folder)
    stage.check()
    stage.reset(0)
    for _ in range(4):
        stage.step()
    with pytest.raises(ValueError, match=r"^'.*frame_5\.png' ") as raised:
        stage.step()
    assert str(raised.value) == f"'{broken}' {what}"
    assert capfd.readouterr() == ("", "")


def test_a_jpeg_that_was_cut_off_is_not_shown_half_gray(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "a.jpg"
    noise = np.random.default_rng(0).integers(0, 255, (48, 64, 3), np.uint8)
    cv2.imwrite(str(file), noise)
    Images(path=file).check()
    file.write_bytes(file.read_bytes()[:-200])
    assert refusal(Images(path=file)) == f"'{file}' is truncated or damaged"
    assert capfd.readouterr() == ("", "")


def test_a_picture_of_another_size_stops_with_one_line(folder: Path) -> None:
    cv2.imwrite(str(folder / "frame_3.png"), np.zeros((30, 40, 3), np.uint8))
    source = Images(path=folder)
    source.reset(0)
    source.step()
    source.step()
    with pytest.raises(ValueError, match=r"^a frame is 40x30, but the first was 64x48: set 'size'$"):
        source.step()


def test_a_size_makes_pictures_of_different_sizes_equal(folder: Path, play: Play) -> None:
    cv2.imwrite(str(folder / "frame_3.png"), np.zeros((30, 40, 3), np.uint8))
    assert {image.pixels.shape for image in play(Images(path=folder, size=(32, 24)))} == {(24, 32, 3)}
