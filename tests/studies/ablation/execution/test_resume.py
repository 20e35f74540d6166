"""A study goes on where it was, and only there."""

from __future__ import annotations

import dataclasses
import fcntl
import os
import shutil
import signal
from collections.abc import Callable
from typing import Any

import pytest

from graphnav.core.cli import main
from graphnav.studies.ablation.execution.study_folder import read_plan
from graphnav.studies.ablation.plan.plan_file import save_plan

Wait = Callable[[Callable[[], object]], None]


def test_what_is_there_is_not_made_again(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    study.run(seeds="0:2")
    first = study.runs
    assert len(first) == 4
    capsys.readouterr()
    assert study.run(seeds="0:4") == 0
    assert "4 of 8 runs are finished already" in capsys.readouterr().out
    assert first.items() <= study.runs.items()
    assert len(study.rows) == 8
    assert study.run(seeds="1:2") == 0
    assert {row["seed"] for row in study.rows} == {"1"}
    assert len(study.runs) == 8


def test_a_run_that_is_lost_is_made_again_with_the_same_results(study: Any) -> None:
    study.run()
    results, runs = study.results, study.runs
    shutil.rmtree(study.out / "runs" / "toy" / "robot.odd=fine" / "2")
    (study.out / "results.csv").unlink()
    assert study.run() == 0
    assert study.results == results
    assert {name for name, made in study.runs.items() if made != runs[name]} == {"toy/robot.odd=fine/2"}


def test_what_a_killed_process_left_does_not_count_and_goes(study: Any) -> None:
    study.run(seeds="0:1")
    left = study.out / ".scratch" / "half"
    left.mkdir(parents=True)
    (left / "summary.json").write_text("{")
    (study.out / ".plan.json").write_text("{")
    assert study.run(seeds="0:2") == 0
    assert not (study.out / ".scratch").exists()
    assert len(study.rows) == 4


def test_a_variant_more_adds_its_runs(study: Any) -> None:
    study.run()
    before = study.runs
    assert study.run(vary="robot.odd=fine,contact,raise") == 0
    assert before.items() <= study.runs.items()
    assert len(study.rows) == 12


def refused(study: Any, capsys: pytest.CaptureFixture[str], *words: str, **options: Any) -> str:
    """Return the error of a study that is refused, and check that nothing was run."""
    before = study.runs
    capsys.readouterr()
    assert study.run(*words, **options) == 2
    assert study.runs == before
    return capsys.readouterr().err


def test_another_study_is_refused(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    study.run(seeds="0:1")
    hint = f"  choose another folder with -o, or remove {study.out}\n"
    said = refused(study, capsys, vary="robot.odd=fine,raise")
    assert said == f"{study.out} holds another study of this name: it has toy with robot.odd=contact\n{hint}"
    said = refused(study, capsys, vary="robot.odd=contact,fine")
    assert said == f"{study.out} holds a study whose base is robot.odd=fine, not robot.odd=contact\n{hint}"
    said = refused(study, capsys, "--set", "run.until_s=7")
    what = f"toy with robot.odd=fine has changed since its runs in {study.out} were made"
    assert said == f"{what}: 'until_s: 5.0' was, 'until_s: 7.0' is\n{hint}"


def test_a_line_is_not_paired_with_one_of_another_key(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    study.run(seeds="0:1")
    plan = study.out / "plan.json"
    plan.write_text(plan.read_text().replace("until_s: 5.0", "during_s: 5.0"))
    assert ": 'during_s: 5.0' was, and is not\n" in refused(study, capsys)


def test_a_plan_without_a_run_gives_way(study: Any) -> None:
    study.run(seeds="0:1")
    shutil.rmtree(study.out / "runs")
    assert study.run(vary="robot.odd=contact,fine", seeds="0:1") == 0
    assert len(study.runs) == 2


def test_a_metric_that_no_run_has_is_named(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    assert study.run("--metrics", "drive.way_m,drive.turn_rad", seeds="0:1") == 0
    assert "'drive.turn_rad' is undefined in all runs\n" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--report", "out", "--metrics", "a.b"], "--report reads an existing study; --metrics would have no effect"),
        (["toy", "--report", "out", "-o", "x"], "--report reads an existing study; toy, -o would have no effect"),
        (["--compare", "a", "b", "--seeds", "0:1"], "--compare reads an existing study; --seeds would have no effect"),
        (
            ["--compare", "a", "b", "--contrast", "x,y"],
            "--compare reads an existing study; --contrast would have no effect",
        ),
        (
            ["--report", "out", "--compare", "a", "b"],
            "--report reads an existing study; --compare would have no effect",
        ),
    ],
)
def test_what_would_change_nothing_is_refused(words: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["ablate", *words]) == 2
    assert capsys.readouterr().err.startswith(f"{said}\n  remove ")


def test_a_plugin_that_has_changed_is_refused(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    study.run(seeds="0:1")
    with study.plugin.open("a") as file:
        file.write("# fixed\n")
    assert f"the runs in {study.out} were made with another {study.plugin}: " in refused(study, capsys)


def test_a_default_that_has_changed_is_refused(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    study.run(seeds="0:1")
    study.plugin.write_text(study.plugin.read_text().replace("param(1, ge=1", "param(2, ge=1"))
    assert "'times: 1  # default' was, 'times: 2  # default' is" in refused(study, capsys)


def test_other_versions_are_refused(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    study.run(seeds="0:1")
    plan = read_plan(study.out)
    save_plan(dataclasses.replace(plan, versions={**plan.versions, "numpy": "0.9"}), study.out / "plan.json")
    assert f"were made with another numpy: 0.9, now {plan.versions['numpy']}\n" in refused(study, capsys)


def test_a_folder_of_another_program_is_refused(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    study.out.mkdir()
    (study.out / "thesis.tex").touch()
    said = refused(study, capsys)
    assert said == f"{study.out} holds thesis.tex, but no study (plan.json)\n  choose another folder with -o\n"
    shutil.rmtree(study.out)
    study.out.touch()
    assert refused(study, capsys) == f"{study.out} is a file\n  choose another folder with -o\n"


def test_a_plan_that_is_none_is_refused(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    study.out.mkdir()
    (study.out / "plan.json").write_text("[]")
    assert f"{study.out / 'plan.json'} is not the plan of a study\n" in refused(study, capsys)


def test_two_at_once_in_one_folder_are_refused(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    study.run(seeds="0:1")
    lock = os.open(study.out / ".lock", os.O_RDWR)
    fcntl.flock(lock, fcntl.LOCK_EX)
    said = refused(study, capsys)
    os.close(lock)
    assert said == (
        f"another 'graphnav ablate' is at work in {study.out}\n  wait for it, or choose another folder with -o\n"
    )
    assert study.run(seeds="0:1") == 0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_ends_in_a_line_and_keeps_what_is_made(study: Any, wait_until: Wait, number: int) -> None:
    endless = {"vary": "robot.times=1,100000000", "seeds": "0:1"}
    process = study.start("--set", "run.until_s=1e9", **endless)
    wait_until(lambda: len(study.runs) == 1)
    os.killpg(process.pid, number)
    out, said = process.communicate()
    assert process.returncode == 130
    assert (out, said) == ("", "stopped: 1 of 2 runs are finished; resume with the same command\n")
    with pytest.raises(ProcessLookupError):
        os.killpg(process.pid, 0)
    assert not (study.out / ".scratch").exists()


def test_kill_9_of_the_parent_alone_leaves_no_process_and_no_half_run(study: Any, wait_until: Wait) -> None:
    process = study.start("--set", "run.until_s=1e9", vary="robot.times=1,100000000", seeds="0:1")
    wait_until(lambda: len(study.runs) == 1)
    process.kill()
    process.communicate()
    wait_until(lambda: not group_exists(process.pid))
    assert len(study.runs) == 1


def group_exists(group: int) -> bool:
    """Return whether a process of the group exists that is not a zombie."""
    for stat in os.listdir("/proc"):
        try:
            with open(f"/proc/{stat}/stat") as file:
                fields = file.read().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[2]) == group and fields[0] != "Z":
            return True
    return False
