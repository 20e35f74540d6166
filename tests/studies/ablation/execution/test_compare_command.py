"""``graphnav ablate --compare A B --fail-if ...`` in a pipeline."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from graphnav.core.cli import main


@pytest.fixture
def folders(study: Any, capsys: pytest.CaptureFixture[str]) -> tuple[str, str]:
    """Return a study and one whose robot goes further."""
    study.run()
    first = str(study.out.rename(study.out.with_name("first")))
    study.run("--set", "robot.times=2")
    capsys.readouterr()
    return first, str(study.out)


def test_a_case_that_meets_a_condition_fails(folders: tuple[str, str], capsys: pytest.CaptureFixture[str]) -> None:
    a, b = folders
    assert main(["ablate", "--compare", a, b, "--fail-if", "drive.way_m < 0"]) == 0
    assert "drive.way_m < 0:" not in capsys.readouterr().out
    assert main(["ablate", "--compare", b, a, "--fail-if", "drive.way_m < -20", "--fail-if", "drive.way_m < -2"]) == 1
    lines = [line for line in capsys.readouterr().out.splitlines() if line.startswith("drive.way_m <")]
    assert [line.partition(": B - A is")[0] for line in lines] == [
        "drive.way_m < -20: toy, robot.odd=fine",
        "drive.way_m < -2: toy, robot.odd=fine",
        "drive.way_m < -2: toy, robot.odd=contact",
    ]
    assert "0–4" in lines[0]


def test_what_cannot_be_judged_fails(folders: tuple[str, str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["ablate", "--compare", *folders, "--fail-if", "drive.turn_rad > 9"]) == 1
    assert "toy, robot.odd=fine: no world of both studies has this metric" in capsys.readouterr().out


def test_wrong_conditions_are_refused(
    folders: tuple[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["ablate", "--compare", *folders, "--fail-if", "drive.wya_m < 0"]) == 2
    assert capsys.readouterr().err == (
        "--fail-if: 'drive.wya_m < 0': the studies have no metric 'drive.wya_m'\n  did you mean 'drive.way_m'?\n"
    )
    assert main(["ablate", "toy", "--fail-if", "drive.way_m < 0"]) == 2
    assert capsys.readouterr().err == "--fail-if is for --compare, which compares two studies\n  add --compare A B\n"
    assert not (tmp_path / "ablations").exists()


def test_a_case_that_is_missing_fails(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    study.run()
    first = str(study.out.rename(study.out.with_name("first")))
    study.run(vary="robot.odd=fine")
    capsys.readouterr()
    assert main(["ablate", "--compare", first, str(study.out), "--fail-if", "drive.way_m < -99"]) == 1
    said = capsys.readouterr().out
    assert "drive.way_m < -99: toy, robot.odd=contact: no world of both studies has this metric" in said
    assert main(["ablate", "--compare", str(study.out), first, "--fail-if", "drive.way_m < -99"]) == 0
