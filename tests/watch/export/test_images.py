"""Images are exported as they are, named by their stamps."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from graphnav import Image, Recording
from graphnav.core.cli import main
from graphnav.core.codec import encode
from graphnav.core.record import LogWriter


def test_every_image_is_a_file_with_its_pixels(drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    frames = tmp_path / "frames"
    assert main(["export", str(drive), "--to", "images", "-o", str(frames)]) == 0
    assert capsys.readouterr().out.startswith(f"{frames}: 21 pictures, ")
    with Recording(drive / "run.lcmlog") as recording:
        sent = {utime: message for utime, _, message in recording.messages("robot.image")}
    assert sorted(int(file.stem) for file in frames.iterdir()) == sorted(sent)
    for file in frames.iterdir():
        image = sent[int(file.stem)]
        assert isinstance(image, Image)
        assert np.array_equal(np.asarray(cv2.imread(str(file), cv2.IMREAD_UNCHANGED)), image.pixels)


def test_colours_stay(tmp_path: Path) -> None:
    pixels = np.random.default_rng(0).integers(0, 255, (5, 7, 3), np.uint8)
    with LogWriter(tmp_path / "a.lcmlog") as writer:
        writer.write("CAMERA", 9, encode(Image(pixels=pixels), 123, 0))
    words = ["export", str(tmp_path / "a.lcmlog"), "--to", "images", "--channel", "CAMERA", "-o", str(tmp_path / "out")]
    assert main(words) == 0
    assert np.array_equal(np.asarray(cv2.imread(str(tmp_path / "out" / f"{123:016d}.ppm")))[..., ::-1], pixels)


def test_a_channel_without_images_is_refused(drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["export", str(drive), "--to", "images", "-o", str(tmp_path / "out")]
    assert main([*words, "--channel", "robot.motion"]) == 2
    assert capsys.readouterr().err == (
        "channel 'robot.motion' holds no images\n  select one with --channel: robot.image\n"
    )
    assert not (tmp_path / "out").exists()
