"""Every run of a plan has its result: by however many processes, and whatever its stages do to them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from graphnav import Recording
from graphnav.core.run_folder import RunFolder
from graphnav.studies.ablation.execution.execute_jobs import DIED

FINE = 2
"""The seed of four from which the toy's own is even, so that it comes to no grief."""


def test_the_runs_and_the_tables_are_there(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    assert study.run() == 0
    assert [(row["variant"], row["seed"], row["outcome"]) for row in study.rows] == [
        *(("robot.odd=fine", str(seed), "goal") for seed in range(4)),
        *(("robot.odd=contact", str(seed), "goal" if seed == FINE else "contact") for seed in range(4)),
    ]
    assert [float(row["drive.way_m"]) for row in study.rows] == [15, 10, 15, 3, 1, 1, 15, 1]
    assert not (study.out / ".scratch").exists()
    assert "contact 3, goal 1" in capsys.readouterr().out
    with Recording(study.out / "runs" / "toy" / "robot.odd=contact" / "2" / RunFolder.LOG) as log:
        assert log.truncated is None
        assert log.count("robot.twist") == 6


def test_one_process_and_three_give_the_same_results(study: Any) -> None:
    study.run(jobs=1)
    one = study.results
    study.out.rename(study.out.with_name("one"))
    study.run(jobs=3)
    assert study.results == one


@pytest.mark.parametrize("vary", ["robot.odd=fine,raise", "drive=toy.distance,toy.unready"])
def test_a_stage_that_fails_is_a_row_with_its_reason(study: Any, vary: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert study.run(vary=vary) == 0
    failed = [row for row in study.rows if row["outcome"] == "failed"]
    reason, count = {
        "robot": ("stage 'robot' (toy.walker) failed at 0.10 s: worn out", 3),
        "drive": ("stage 'drive' (toy.unready) failed at 0.00 s: no model", 4),
    }[vary.partition(".")[0].partition("=")[0]]
    assert [row["failure"].splitlines()[0] for row in failed] == [reason] * count
    assert all("Error at my_toys.py:" in row["failure"].splitlines()[1] for row in failed)
    assert len(study.rows) == 8
    assert "failed: stage" in capsys.readouterr().out


@pytest.mark.parametrize("grief", ["exit", "kill"])
def test_a_stage_that_kills_its_process_is_a_row_and_takes_nothing_else_with_it(study: Any, grief: str) -> None:
    assert study.run(vary=f"robot.odd=fine,{grief}") == 0
    assert [row["outcome"] for row in study.rows] == ["goal"] * 4 + ["failed", "failed", "goal", "failed"]
    last_call = "the last call was step of stage 'robot' (toy.walker) at 0.10 s"
    assert {row["failure"] for row in study.rows} == {"", f"{DIED}; {last_call}"}
    before = study.runs
    assert study.run(vary=f"robot.odd=fine,{grief}") == 0
    assert study.runs == before


def test_a_stage_that_hangs_is_a_row_and_takes_nothing_else_with_it(study: Any) -> None:
    assert study.run("--stall-s", "2", vary="robot.odd=fine,hang") == 0
    assert [row["outcome"] for row in study.rows] == ["goal"] * 4 + ["failed", "failed", "goal", "failed"]
    said = "stage 'robot' (toy.walker) failed at 0.10 s: step did not return within 2 s of wall time"
    assert {row["failure"] for row in study.rows} == {"", said}


def test_a_run_whose_process_died_once_is_made_again(study: Any, tmp_path: Path) -> None:
    note = tmp_path / "note"
    assert study.run("--set", f"robot.once={note}", vary="robot.odd=fine,kill", seeds="0:2") == 0
    assert note.exists()
    assert [row["outcome"] for row in study.rows] == ["goal"] * 4


def test_a_disk_that_refuses_ends_the_study_in_a_line_and_what_is_made_stays(
    study: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    study.run(seeds="0:2")
    before = study.runs
    kept = study.out / "runs" / "toy"
    kept.rename(study.out / "kept")
    kept.write_text("in the way")
    capsys.readouterr()
    assert study.run() == 1
    assert capsys.readouterr().err == (
        f"cannot write into {study.out}: Not a directory\n"
        "  0 of 8 runs are finished; fix this and resume with the same command\n"
    )
    kept.unlink()
    (study.out / "kept").rename(kept)
    assert study.run() == 0
    assert len(study.rows) == 8
    assert before.items() <= study.runs.items()


@pytest.mark.long
def test_a_log_that_cannot_be_written_is_no_result(study: Any) -> None:
    long = {"vary": "robot.times=1000,1500"}
    process = study.start("--set", "run.until_s=1e6", max_kb=64, **long)
    _, said = process.communicate()
    assert process.returncode == 1
    assert said == (
        f"cannot write into {study.out / '.scratch'}: File too large\n"
        "  0 of 8 runs are finished; fix this and resume with the same command\n"
    )
    assert study.run("--set", "run.until_s=1e6", **long) == 0
    assert len(study.rows) == 8
