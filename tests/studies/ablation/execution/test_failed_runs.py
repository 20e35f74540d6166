"""Failed runs: told at once, fatal with --fail-fast, and where there is nothing else."""

from __future__ import annotations

from typing import Any

import pytest

import graphnav
from graphnav.core.cli import main
from graphnav.core.errors import GraphnavError

RAISES = "robot.odd=fine,raise"
FIRST = (
    "failed: toy, robot.odd=raise, seed 0: stage 'robot' (toy.walker) failed at 0.10 s: worn out\n"
    "  ValueError at my_toys.py:45 in _come_to_grief\n"
    "  out/runs/toy/robot.odd=raise/0/run.lcmlog\n"
)


def test_a_failed_run_is_told_with_its_log_while_the_study_goes_on(
    study: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    assert study.run(vary=RAISES) == 0
    told = [FIRST.replace("seed 0", f"seed {seed}").replace("/0/", f"/{seed}/") for seed in (0, 1, 3)]
    assert capsys.readouterr().err == "".join(told)
    assert (study.out / "runs/toy/robot.odd=raise/1/run.lcmlog").is_file()
    assert len(study.rows) == 8


def test_fail_fast_stops_at_the_first_failed_run_and_stops_again(
    study: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    for _ in range(2):
        assert study.run("--fail-fast", vary=RAISES) == 1
        assert capsys.readouterr().err == (
            f"{FIRST}stopped by --fail-fast: 2 of 8 runs are finished; "
            "graphnav ablate --report out writes their tables\n"
        )
        assert len(study.runs) == 2
    assert study.run(vary=RAISES) == 0
    assert len(study.rows) == 8


def test_fail_fast_stops_when_a_process_dies_for_the_first_time(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    assert study.run("--fail-fast", vary="robot.odd=fine,kill") == 1
    said = capsys.readouterr().err
    assert said.startswith("failed: toy, robot.odd=kill, seed 0: its process died\nstopped by --fail-fast: 1 of 8 runs")
    assert len(study.runs) == 1


def test_fail_fast_does_not_mind_a_drive_that_ends_badly(study: Any) -> None:
    assert study.run("--fail-fast") == 0
    assert {row["outcome"] for row in study.rows} == {"goal", "contact"}


def test_a_study_of_which_every_run_failed_failed(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    assert study.run("--set", "drive=toy.unready", seeds="0:1") == 1
    assert capsys.readouterr().err.endswith("every run failed: 2 of 2\n")
    assert main(["ablate", "--report", "out"]) == 1
    assert capsys.readouterr().err == "every run failed: 2 of 2\n"
    assert [row["outcome"] for row in study.rows] == ["failed", "failed"]


def test_from_python_fail_fast_raises(study: Any) -> None:
    arguments: dict[str, Any] = {"vary": {"robot.odd": ["fine", "raise"]}, "plugins": [study.plugin], "jobs": 1}
    with pytest.raises(GraphnavError, match=r"^failed: toy, robot\.odd=raise, seed 0: stage 'robot'"):
        graphnav.ablate("toy", seeds=range(4), folder=study.out, fail_fast=True, **arguments)
    assert len(graphnav.ablate("toy", seeds=range(4), folder=study.out, gallery=0, **arguments).records) == 8
