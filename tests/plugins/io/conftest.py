"""Small pictures and videos, written by OpenCV."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from graphnav import Finished, Image, Source
from graphnav.arrays import Bytes


def frame(number: int, rows: int = 48, cols: int = 64) -> Bytes:
    """Return a blue-green-red picture with its number as brightness of the left half, red on the right."""
    picture = np.zeros((rows, cols, 3), np.uint8)
    picture[:, : cols // 2] = 8 * number
    picture[:, cols // 2 :] = (0, 0, 200)
    return picture


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder of twelve PNG pictures, frame_1.png to frame_12.png, and a text file."""
    path = tmp_path / "frames"
    path.mkdir()
    for number in range(1, 13):
        cv2.imwrite(str(path / f"frame_{number}.png"), frame(number))
    (path / "notes.txt").write_text("no picture")
    return path


@pytest.fixture
def write_video(tmp_path: Path) -> Callable[..., Path]:
    """Return a function that writes a video of 30 frames."""

    def write(name: str = "drive.mp4", codec: str = "mp4v", rate_hz: float = 20.0, frames: int = 30) -> Path:
        path = tmp_path / name
        writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*codec), rate_hz, (64, 48))
        assert writer.isOpened()
        for number in range(frames):
            writer.write(frame(number))
        writer.release()
        return path

    return write


@pytest.fixture
def play() -> Callable[[Source], list[Image]]:
    """Return a function that steps a source to its end."""

    def run(source: Source) -> list[Image]:
        source.check()
        source.reset(0)
        images: list[Image] = []
        try:
            while True:
                images.append(source.step())  # type: ignore[attr-defined]
        except Finished as finished:
            images.append(finished.outputs)
        finally:
            source.close()
        return images

    return run
