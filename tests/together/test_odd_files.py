"""Paths that lead nowhere or to something else than a file: an error of one or two lines, at once."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from graphnav.core.cli import main

GRAPHS = {
    "extends.yaml": "extends: fifo.yaml",
    "video.yaml": "stages: {camera: {use: io.video, with: {path: fifo.yaml, rate_hz: 10}}}",
    "recording.yaml": "stages: {camera: {use: io.recording, with: {path: '*.pgm', times: fifo.yaml}}}",
}


@pytest.mark.parametrize("value", ["~no_such_user/map.yaml", "~/no_such_map.yaml"])
def test_a_path_of_an_unknown_user_is_not_a_file(value: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "corridor_ccw", "--set", f"robot.map={value}"]) == 2
    assert "is not a file" in capsys.readouterr().err


@pytest.mark.timeout(120)
@pytest.mark.parametrize(
    "words",
    [
        ["check", "fifo.yaml"],
        ["check", "extends.yaml"],
        ["check", "corridor_ccw", "--set", "robot.map=fifo.yaml"],
        ["check", "video.yaml"],
        ["check", "video.yaml", "--set", "camera.path=folder"],
        ["check", "video.yaml", "--set", "camera.path=1.pgm", "--set", "camera.calibration=fifo.yaml"],
        ["check", "recording.yaml"],
        ["check", "corridor_ccw", "--plugin", "fifo.yaml"],
        ["info", "fifo.yaml"],
        ["ablate", "fifo.yaml"],
        ["ablate", "--report", "folder"],
    ],
)
def test_a_fifo_is_refused_unread(
    words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    for name in ("fifo.yaml", "folder/plan.json", "folder/1.png"):
        os.mkfifo(tmp_path / name)
    (tmp_path / "1.pgm").write_bytes(b"P5 2 2 255\n0000")
    for name, text in GRAPHS.items():
        (tmp_path / name).write_text(text)
    assert main(words) in (1, 2)
    said = capsys.readouterr().err
    assert "Traceback" not in said
    assert any(word in said for word in ("regular file", "not a file", "no such file", "there is no"))


def test_a_device_is_refused_unread(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "/dev/zero"]) == 2
    assert capsys.readouterr().err == "/dev/zero: it cannot be read: it is a device, not a regular file\n"
