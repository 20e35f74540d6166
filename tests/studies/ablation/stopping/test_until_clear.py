"""``graphnav ablate --until-clear``: fewer runs, the same ones however they are made."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

import graphnav
from graphnav import UserError
from graphnav.core.cli import main

ARRIVER = '''
from typing import ClassVar

from graphnav import Finished, Metric, Source, Twist, hookimpl, param

FAMILY = "toy"


class Arriver(Source):
    """Arrives in some of ten worlds."""

    metrics: ClassVar = (
        Metric("success", better="higher", if_failed=0.0, is_outcome=True, help="Arrived."),
        Metric("way_m", unit="m", better="lower", help="Way."),
    )
    often: int = param(10, ge=0, doc="in how many of ten worlds it arrives")

    def reset(self, seed: int) -> None:
        self._arrives = seed % 10 < self.often

    def step(self) -> Twist:
        raise Finished("goal", Twist(0.0, 0.0))

    def summary(self) -> dict[str, float]:
        return {"success": float(self._arrives), "way_m": 1.0}


@hookimpl
def graphnav_stages():
    return [Arriver]
'''
STUDY = """\
graph: toy
seeds: 0:40
vary: {robot.often: [10, 0, 9]}
metrics: [robot.success]
"""


@pytest.fixture
def words(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    monkeypatch.chdir(tmp_path)
    Path("arriver.py").write_text(ARRIVER)
    Path("toy.yaml").write_text("run: {until_s: 1}\nstages:\n  robot: {use: toy.arriver}\n")
    Path("mine.yaml").write_text(STUDY)
    return ["ablate", "mine", "--plugin", "arriver.py", "--gallery", "0", "--until-clear"]


def test_a_decided_variant_has_fewer_runs_on_one_process_as_on_two(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*words, "-j", "1", "-o", "one"]) == 0
    said = capsys.readouterr().out
    assert "toy, robot.often=0: told from the base after 10 worlds" in said
    assert "toy, robot.often=9: not told from the base after 40 worlds" in said
    assert "pending" not in said
    assert "4 of 5 studies" not in said
    assert "Stopped by --until-clear: 5 worlds at a time" in Path("one/table.md").read_text()
    assert "Stopped by --until-clear: 5 worlds at a time" in Path("one/report.html").read_text()
    assert len(list(Path("one/runs/toy/robot.often=0").iterdir())) == 10
    results = Path("one/results.csv").read_bytes()
    assert main([*words, "-j", "2", "-o", "two"]) == 0
    assert Path("two/results.csv").read_bytes() == results
    assert main([*words, "-j", "1", "-o", "one"]) == 0
    assert Path("one/results.csv").read_bytes() == results


def test_what_is_missing_of_an_interrupted_round_is_pending(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*words, "-j", "1", "-o", "one"]) == 0
    assert "finished: 90 runs" in Path("one/report.html").read_text()
    shutil.rmtree("one/runs/toy/robot.often=9/39")
    capsys.readouterr()
    assert main(["ablate", "--report", "one"]) == 0
    assert "1 of the runs of the next round are pending" in capsys.readouterr().out
    assert "not finished: so far 89 runs, 1 more in the next round" in Path("one/report.html").read_text()


def test_without_it_the_pending_runs_are_made(words: list[str]) -> None:
    study = graphnav.ablate("mine", plugins=["arriver.py"], gallery=0, jobs=1, folder="one", until_clear=True)
    assert study.plan.command.endswith("--until-clear")
    assert len(study.records) == 40 + 10 + 40
    assert main([*words[:-1], "-j", "1", "-o", "one"]) == 0
    assert len(list(Path("one/runs/toy/robot.often=0").iterdir())) == 40
    assert "until-clear" not in Path("one/table.md").read_text()


def test_a_metric_without_bounds_is_refused_before_anything_runs(words: list[str]) -> None:
    with pytest.raises(
        UserError, match=r"^--until-clear: 'robot\.way_m' decides, and its stage does not declare a lowest"
    ):
        graphnav.ablate("mine", plugins=["arriver.py"], metrics=["robot.way_m"], until_clear=True)
