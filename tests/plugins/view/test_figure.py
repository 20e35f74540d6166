"""``graphnav figure`` draws again what a log holds."""

from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import pytest

from graphnav.core.cli import main
from graphnav.core.record import Recording

Record = Callable[..., Recording]
DiskOf = Callable[[int], AbstractContextManager[None]]


def test_a_run_folder_gets_its_pictures(record: Record, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record(frames=5)
    assert main(["figure", str(tmp_path)]) == 0
    assert capsys.readouterr().out.split() == [str(tmp_path / "map.png"), str(tmp_path / "panels.png")]
    assert (tmp_path / "map.png").stat().st_size > 1000


def test_a_log_is_drawn_into_a_new_folder(record: Record, tmp_path: Path) -> None:
    record(frames=5)
    assert main(["figure", str(tmp_path / "run.lcmlog"), "-o", str(tmp_path / "a b" / "c"), "--video"]) == 0
    assert sorted(p.name for p in (tmp_path / "a b" / "c").iterdir()) == ["map.png", "panels.png", "video.mp4"]


@pytest.mark.parametrize(
    ("name", "said"),
    [("absent", "there is no {}/absent"), ("", "{} holds no run.lcmlog"), ("text", "is not an LCM log")],
)
def test_what_cannot_be_drawn_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, said: str
) -> None:
    (tmp_path / "text").write_text("this is not a log, but a string of some length")
    assert main(["figure", str(tmp_path / name)]) != 0
    told = capsys.readouterr().err
    assert said.format(tmp_path) in told
    assert "Traceback" not in told


@pytest.mark.parametrize("words", [[], ["--at", "0.2s"], ["--every", "0.1s"]])
def test_a_full_disk_is_said_and_no_half_picture_is_left(
    record: Record, tmp_path: Path, disk_of: DiskOf, capsys: pytest.CaptureFixture[str], words: list[str]
) -> None:
    record(frames=5)
    out = tmp_path / "out"
    with disk_of(1000):
        assert main(["figure", str(tmp_path), "-o", str(out), *words]) == 1
    assert capsys.readouterr().err == (
        f"cannot draw into {out}: File too large\n  free space, then run: graphnav figure {tmp_path} -o {out}\n"
    )
    assert not out.exists()


def test_what_was_drawn_before_stays_where_the_disk_is_full(
    record: Record, tmp_path: Path, disk_of: DiskOf, capsys: pytest.CaptureFixture[str]
) -> None:
    record(frames=5)
    assert main(["figure", str(tmp_path)]) == 0
    before = (tmp_path / "map.png").read_bytes()
    capsys.readouterr()
    with disk_of(1000):
        assert main(["figure", str(tmp_path)]) == 1
    assert capsys.readouterr().err.endswith(f"  free space, then run: graphnav figure {tmp_path}\n")
    assert (tmp_path / "map.png").read_bytes() == before
    assert sorted(path.name for path in tmp_path.iterdir()) == ["map.png", "panels.png", "run.lcmlog"]
