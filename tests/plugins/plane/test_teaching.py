"""``tools/teach_learned.py``: a model of one short drive, and arguments that are refused before any drive."""

from __future__ import annotations

from pathlib import Path

import pytest
from graphnav_plane.learning.model_file import read_model
from teach_learned import main

SETTINGS = {"robot.tilt_deg": 50, "planar.model": "models/tilt_50.lcmlog", "run.until_s": 1.5}


@pytest.mark.filterwarnings("ignore:Stochastic Optimizer")
def test_one_drive_with_settings_of_numbers_and_texts_teaches_a_model(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "new" / "model.npz"
    words = [word for target, value in SETTINGS.items() for word in ("--set", f"{target}={value}")]
    assert main(["-o", str(path), "--drives", "1", *words]) == 0
    assert capsys.readouterr().out.count("\n") == 2
    model = read_model(path)
    assert model.about["set"] == SETTINGS
    assert len(model.about["drives"]) == 1


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--drives", "0"], "--drives 0 leaves no drive to teach from\n  write --drives 1 or more\n"),
        (["--set", "robot.tilt_deg"], "--set robot.tilt_deg: this sets nothing\n  write stage=family.stage"),
        (
            ["--set", "robot.tilt_dg=50"],
            "set['robot.tilt_dg']: world.pymunk has no parameter 'tilt_dg'\n  did you mean",
        ),
        (["-o", "file/model.npz"], "cannot write file/model.npz\n  choose another file with -o\n"),
    ],
)
def test_arguments_that_cannot_be_used_are_refused_first(
    words: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("file").touch()
    assert main(["-o", "model.npz", *words]) == 2
    out, err = capsys.readouterr()
    assert err.startswith(said)
    assert not out
    assert not Path("model.npz").exists()
