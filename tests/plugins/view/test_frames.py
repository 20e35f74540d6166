"""``graphnav figure`` draws the frame of any time, and many of them on a sheet."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path

import cv2
import pytest
from graphnav_view.panels.frame_times import nearest

from graphnav.core.cli import main
from graphnav.core.record import LogWriter, Recording

Record = Callable[..., Recording]


def test_the_nearest_frame_is_drawn(record: Record, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record(frames=12)
    assert main(["figure", str(tmp_path), "--at", "0.52s", "--at", "0.98", "--at", "0.5s"]) == 0
    written = capsys.readouterr().out.split()
    assert written == [str(tmp_path / "panels_0.50s.png"), str(tmp_path / "panels_1.00s.png")]
    first, second = (cv2.imread(path) for path in written)
    assert first is not None
    assert second is not None
    assert first.shape == second.shape
    assert (first != second).any()


def test_a_sheet_has_a_frame_for_each_step(record: Record, tmp_path: Path) -> None:
    record(frames=40)
    for every, rows in (("0.5s", 2), ("0.1s", 5)):
        assert main(["figure", str(tmp_path), "--every", every, "-o", str(tmp_path / every)]) == 0
        picture = cv2.imread(str(tmp_path / every / "sheet.png"))
        assert picture is not None
        assert picture.shape[0] == pytest.approx(120 * (1.04 + rows * (0.2 + 1.7 * 0.75 + 0.14)), abs=3)


def test_a_span_bounds_the_sheet(record: Record, tmp_path: Path) -> None:
    record(frames=40)
    words = ["--from", "1s", "--until", "1.45s", "--format", "svg"]
    assert main(["figure", str(tmp_path), "--every", "0.2s", *words]) == 0
    text = (tmp_path / "sheet.svg").read_text()
    assert [f"<!-- {time} s -->" in text for time in ("0.80", "1.00", "1.20", "1.40", "1.60")] == [
        False,
        True,
        True,
        True,
        False,
    ]


@pytest.mark.parametrize(("suffix", "begins"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF-")])
def test_every_picture_comes_in_every_format(record: Record, tmp_path: Path, suffix: str, begins: bytes) -> None:
    record(frames=12, moving=True, contact=True)
    for folder in ("one", "two"):
        words = ["--at", "0.5s", "--every", "0.3s", "--format", suffix, "-o", str(tmp_path / folder)]
        assert main(["figure", str(tmp_path / "run.lcmlog"), *words]) == 0
        words = ["--format", suffix, "-o", str(tmp_path / folder)]
        assert main(["figure", str(tmp_path / "run.lcmlog"), *words]) == 0
    names = [f"map.{suffix}", f"panels.{suffix}", f"panels_0.50s.{suffix}", f"sheet.{suffix}"]
    for name in names:
        first, second = ((tmp_path / folder / name).read_bytes() for folder in ("one", "two"))
        assert first.startswith(begins)
        assert first == second
    assert sorted(path.name for path in (tmp_path / "one").iterdir()) == names


def test_an_svg_is_drawn_in_lines_not_in_pixels(record: Record, tmp_path: Path) -> None:
    record(frames=12)
    assert main(["figure", str(tmp_path), "--format", "svg"]) == 0
    tree = ET.fromstring((tmp_path / "map.svg").read_text())
    assert len(list(tree.iter("{http://www.w3.org/2000/svg}image"))) <= 1  # the colours of the time
    assert len(list(tree.iter("{http://www.w3.org/2000/svg}path"))) > 50


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--at", "9s"], "there is no frame at 9 s\n  the log has frames from 0.00 s to 1.10 s\n"),
        (
            ["--every", "0.1s", "--from", "3s"],
            "there are no frames in this span\n  the log has frames from 0.00 s to 1.10 s\n",
        ),
        (["--from", "3s"], "--from and --until are for a contact sheet\n  add --every 0.5s, or leave them out\n"),
    ],
)
def test_a_time_outside_of_the_log_is_an_error(
    record: Record, tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str], said: str
) -> None:
    record(frames=12)
    assert main(["figure", str(tmp_path), *words]) == 2
    assert capsys.readouterr().err == said


def test_a_sheet_has_an_end(record: Record, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record(frames=230, without=("robot.map", "steer.potential", "flow.flow"))
    assert main(["figure", str(tmp_path), "--every", "0.1s"]) == 2
    assert capsys.readouterr().err == (
        "a frame every 0.1 s gives 230 frames, but a sheet holds at most 200\n"
        "  write --every 0.12s or more, or shorten the span: --from, --until\n"
    )


def test_the_clock_of_a_logger_does_not_matter(record: Record, tmp_path: Path) -> None:
    """A logger stamps events by the time of day; the messages of a lockstep run begin at 0."""
    logged = tmp_path / "logged"
    with record(frames=12) as recording, LogWriter(logged) as log:
        for event in recording.events():
            log.write(event.channel, 1_700_000_000_000_000 + event.utime, event.data)
    assert main(["figure", str(logged), "--at", "0.5s", "-o", str(tmp_path / "out")]) == 0
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["panels_0.50s.png"]


def test_a_log_that_is_cut_short_says_so(record: Record, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = record(frames=12).path
    path.write_bytes(path.read_bytes()[:-100])
    assert main(["figure", str(path), "--at", "0.5s"]) == 0
    assert "is truncated; the pictures show the rest" in capsys.readouterr().err


def test_what_no_camera_saw_cannot_be_drawn(record: Record, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record(frames=12, without=("robot.image", "flow.flow", "plane.plane"))
    for words in (["--at", "0.5s"], ["--every", "0.5s"]):
        assert main(["figure", str(tmp_path), *words]) == 2
        assert "contains nothing to draw" in capsys.readouterr().err


def test_the_earlier_of_two_frames_as_near_is_taken() -> None:
    assert [nearest([0, 10, 20], at) for at in (-5, 0, 4, 5, 6, 15, 99)] == [0, 0, 0, 0, 10, 10, 20]
