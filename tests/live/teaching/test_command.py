"""``graphnav teach`` leaves a log of one message: the last planar model that the graph published."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from pathlib import Path

import pytest

from graphnav import PlanarModel, Recording
from graphnav.core.cli import main
from tests.forked_commands import forked_graphnav

TEACH = ["teach", "teach_downward", "--set", "teach.terms=[v]", "--set", "teach.every_frames=5"]


def test_the_last_model_is_saved_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "new" / "model.lcmlog"
    assert main([*TEACH, "--until", "1.2", "-o", str(path)]) == 0
    assert capsys.readouterr().out.endswith("v on 40 x 30 cells of 4 px, from 10 frames\n")
    with Recording(path) as log:
        assert log.n_events == 1
        _, _, model = log.message("teach.planar_model", 0)
    assert isinstance(model, PlanarModel)
    assert model.frames == 10


def test_a_model_that_is_there_is_kept_unless_forced(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "model.lcmlog"
    path.write_text("precious")
    assert main([*TEACH, "-o", str(path)]) == 2
    assert capsys.readouterr().err == (f"{path} already exists\n  choose another file, or replace it with --force\n")
    assert path.read_text() == "precious"


def test_too_short_a_drive_teaches_nothing_and_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*TEACH, "--until", "0.3", "-o", str(tmp_path / "model.lcmlog")]) == 2
    assert "did not publish a planar model\n  no turn to the right was driven; teach for" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_graph_without_a_teacher_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["teach", "approach", "-o", str(tmp_path / "model.lcmlog")]) == 2
    assert "has 0 channels with a planar model, but teaching needs one" in capsys.readouterr().err


def test_ctrl_c_saves_no_model_that_is_half_taught(tmp_path: Path) -> None:
    path, scratch = tmp_path / "model.lcmlog", tmp_path / "scratch"
    path.write_text("precious")
    scratch.mkdir()
    command = [str(forked_graphnav()), *TEACH, "--until", "1e6", "--force", "-o", str(path)]
    pipe, env = subprocess.PIPE, os.environ | {"TMPDIR": str(scratch)}
    teaching = subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, start_new_session=True, env=env)
    deadline = time.monotonic() + 60
    while teaching.poll() is None and time.monotonic() < deadline and not has_model(scratch):
        time.sleep(0.005)
    os.killpg(teaching.pid, signal.SIGINT)
    assert teaching.communicate(timeout=60) == (
        "",
        f"interrupted: teaching was not finished, and {path} is not written\n",
    )
    assert teaching.returncode == 130
    assert path.read_text() == "precious"
    assert list(scratch.iterdir()) == []


def has_model(scratch: Path) -> bool:
    """Return whether the log of what is taught has a model: it is far larger than anything else in it."""
    return any(log.stat().st_size > 20_000 for log in scratch.glob("*/run.lcmlog"))


def test_a_span_that_was_asked_for_is_of_live_runs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*TEACH, "--until-taught", "0.3,1", "-o", str(tmp_path / "model.lcmlog")]) == 2
    assert capsys.readouterr().err == (
        "--until-taught is for live runs, but this graph runs in lockstep\n  add --live, or leave it out\n"
    )


@pytest.mark.parametrize("text", ["0.3", "0.3,x", "0.3,0", "-1,1", "nan,1", "0.3,inf", "1,2,3"])
def test_what_is_not_a_speed_and_a_turning_rate_is_refused(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main([*TEACH, f"--until-taught={text}", "-o", "model.lcmlog"])
    assert ended.value.code == 2
    assert f"'{text}' is not a speed and a turning rate above 0, such as 0.3,1.2" in capsys.readouterr().err
