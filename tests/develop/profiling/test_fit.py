"""The largest size of pictures that keeps a graph's rate, and how that is told."""

from __future__ import annotations

import re
from pathlib import Path

import cv2
import numpy as np
import pytest

from graphnav import UserError
from graphnav.core.cli import main
from graphnav.core.machine import CpuQuota
from graphnav.develop.profiling.fit import Fit, Rate

WORLD = """\
run: {until_s: 0.3}
stages:
  robot: {use: world.pymunk, with: {map: maps/pillars.yaml, rate_hz: 100}}
"""


@pytest.mark.parametrize(
    ("fit", "told"),
    [
        (
            Fit(20, (Rate((160, 120), 75), Rate((320, 240), 24.6), Rate((640, 480), 7))),
            "fits on this machine: 20 Hz up to 320x240 (measured 160x120: 75 Hz, 320x240: 24.6 Hz, 640x480: 7 Hz)",
        ),
        (
            Fit(10, (Rate((160, 120), 9.5),), 25),
            "does not fit on 25 % of a core of this machine: 10 Hz at any size (160x120: 9.5 Hz)",
        ),
        (Fit(10, (Rate(None, 31.4),)), "fits on this machine: 10 Hz (measured 31.4 Hz; one size of pictures)"),
        (
            Fit(10, (Rate((160, 120), 50), Rate((320, 240), 0, "planar: no"))),
            "fits on this machine: 10 Hz up to 160x120 (measured 160x120: 50 Hz)\n  320x240 does not run: planar: no",
        ),
    ],
)
def test_how_it_is_told(fit: Fit, told: str) -> None:
    assert str(fit) == told


def test_a_graph_is_measured_with_larger_and_larger_pictures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("world.yaml").write_text(WORLD)
    assert main(["profile", "world.yaml", "--fit"]) == 0
    last = capsys.readouterr().out.splitlines()[-1]
    assert re.match(r"(fits|does not fit) on this machine: 100 Hz .*160x120: [\d.e+]+ Hz", last)


def test_the_rate_of_a_video_is_its_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    writer = cv2.VideoWriter("drive.mp4", cv2.VideoWriter.fourcc(*"mp4v"), 20.0, (160, 120))
    for level in range(60):
        writer.write(np.full((120, 160, 3), level, np.uint8))
    writer.release()
    Path("video.yaml").write_text("stages:\n  camera: {use: io.video, with: {path: drive.mp4}}\n")
    assert main(["profile", "video.yaml", "--fit"]) == 0
    assert "on this machine: 20 Hz" in capsys.readouterr().out.splitlines()[-1]


def test_a_share_of_a_core(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    try:
        with CpuQuota(50):
            pass
    except UserError as error:
        pytest.skip(str(error))
    monkeypatch.chdir(tmp_path)
    Path("world.yaml").write_text(WORLD)
    assert main(["profile", "world.yaml", "--budget", "50"]) == 0
    assert "on 50 % of a core of this machine: 100 Hz" in capsys.readouterr().out.splitlines()[-1]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--budget", "20", "--clock", "cpu"], "--budget is measured by wall time\n  leave out --clock cpu\n"),
        (["--budget", "0"], "argument --budget: '0' is not a share of a core, from 1 to 100 percent\n"),
    ],
)
def test_what_cannot_be_measured(options: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    try:
        status = main(["profile", "approach", *options])
    except SystemExit as error:
        status = int(str(error.code))
    assert status == 2
    assert capsys.readouterr().err.endswith(said)
