"""``graphnav figure`` draws again what a log holds."""

from collections.abc import Callable
from pathlib import Path

import pytest

from graphnav.cli import main
from graphnav.record import Recording

Record = Callable[..., Recording]


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
    ("name", "said"), [("absent", "there is no {}/absent"), ("", "{} holds no run.lcmlog"), ("text", "is no LCM log")]
)
def test_what_cannot_be_drawn_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, said: str
) -> None:
    (tmp_path / "text").write_text("this is no log, but a text of some length")
    assert main(["figure", str(tmp_path / name)]) != 0
    told = capsys.readouterr().err
    assert said.format(tmp_path) in told
    assert "Traceback" not in told
