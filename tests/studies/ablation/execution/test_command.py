"""``graphnav ablate``: what it asks, refuses and writes."""

from __future__ import annotations

import argparse
import json
import os
import pty
import re
import shutil
import subprocess
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import pytest

from graphnav.core.cli import main
from graphnav.studies.ablation.worker import STALL_S
from graphnav.studies.commands.ablate import main as ablate
from tests.forked_commands import forked_graphnav

DiskOf = Callable[[int], AbstractContextManager[None]]


def test_many_runs_without_a_terminal_to_ask_are_refused(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    assert study.run(seeds="0:501") == 2
    assert capsys.readouterr().err == (
        "1002 runs are pending, and cannot ask for confirmation: not a terminal\n  add --yes, or use fewer seeds\n"
    )
    assert study.runs == {}


@pytest.mark.parametrize("answer", ["n", ""])
def test_many_runs_are_asked_for_with_the_time_that_they_take(study: Any, answer: str) -> None:
    ours, theirs = pty.openpty()
    words = study.words("--set", "run.until_s=0.3", seeds="0:501")
    process = subprocess.Popen([str(forked_graphnav()), *words], stdin=theirs, stdout=theirs, stderr=subprocess.DEVNULL)
    os.close(theirs)
    os.write(ours, f"{answer}\n".encode())
    said = b""
    with open(ours, "rb", buffering=0) as terminal:
        try:
            while block := terminal.read(4096):
                said += block
        except OSError:  # so a terminal says that the other end is closed
            pass
    assert process.wait() == 0
    assert re.search(rb"\d+ runs left, 2 at once: about .* to .*\. Continue\? \[y/N\]", said)
    assert b"no more runs" in said
    assert 3 <= len(study.runs) < 150


def test_nothing_is_run_before_a_wrong_study_is_refused(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    assert study.run(vary="robot.odd=fine,nonsense") == 2
    assert "--vary robot.odd=fine,nonsense" in capsys.readouterr().err
    assert not study.out.exists()
    assert main(["ablate"]) == 2
    assert capsys.readouterr().err.startswith("no study is named\n")


def test_a_cluster_that_is_not_there_is_refused(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    for address in ("tcp://127.0.0.1:1", "nonsense", "tcp://127.0.0.1:99999"):
        assert study.run("--cluster", address) == 2
        assert capsys.readouterr().err == (
            f"--cluster {address}: no scheduler answers there\n"
            "  give the address that 'dask scheduler' prints, as tcp://host:8786\n"
        )
    assert study.runs == {}


def test_the_report_is_made_again_from_the_runs_alone(study: Any) -> None:
    study.run()
    names = ("results.csv", "timing.csv", "table.md", "report.html")
    before = {name: (study.out / name).read_bytes() for name in names}
    moved = study.out.rename(study.out.with_name("moved"))
    for name in names:
        (moved / name).unlink()
    assert main(["ablate", "--report", str(moved)]) == 0
    assert {name: (moved / name).read_bytes() for name in names} == before
    study.plugin.unlink()
    assert main(["ablate", "--report", str(moved)]) == 0
    assert (moved / "results.csv").read_bytes() == before["results.csv"]


def test_a_disk_that_fills_up_leaves_every_table_and_the_report_complete(
    study: Any, disk_of: DiskOf, capsys: pytest.CaptureFixture[str]
) -> None:
    study.run()
    former = files(study.out)
    shutil.rmtree(study.out / "runs" / "toy" / "robot.odd=fine" / "2")
    complete = Path(shutil.copytree(study.out, study.out.with_name("complete")))
    assert main(["ablate", "--report", str(complete)]) == 0
    new = files(complete)
    changed = {name for name in new if new[name] != former[name]}
    assert changed == {"results.csv", "timing.csv", "table.md", "report.html"}
    for n_bytes in sorted(len(new[name]) - 1 for name in changed):
        capsys.readouterr()
        with disk_of(n_bytes):
            assert main(["ablate", "--report", str(study.out)]) == 1
        said = capsys.readouterr().err
        assert said.startswith(f"cannot write {study.out}/")
        assert said.endswith(": File too large\n")
        found = files(study.out)
        assert found.keys() == former.keys()
        assert all(found[name] in (former[name], new[name]) for name in found)


def test_a_disk_without_space_for_the_plan_is_named(
    study: Any, disk_of: DiskOf, capsys: pytest.CaptureFixture[str]
) -> None:
    with disk_of(100):
        assert study.run() == 1
    assert capsys.readouterr().err.startswith(f"cannot write {study.out / 'plan.json'}: File too large\n")
    assert not (study.out / "plan.json").exists()
    assert study.run() == 0


def test_calls_that_hang_have_the_same_limit_from_every_door() -> None:
    parser = argparse.ArgumentParser()
    ablate.declare(parser)
    assert parser.parse_args(["toy"]).stall_s == STALL_S


def test_a_study_whose_reader_leaves_is_made_all_the_same(study: Any) -> None:
    with study.start() as process:
        process.stdout.close()
        assert process.stderr.read() == ""
        assert process.wait(60) == 0
    assert len(study.rows) == 8
    assert {"results.csv", "timing.csv", "table.md", "report.html"} <= files(study.out).keys()


def files(folder: Path) -> dict[str, bytes]:
    """Return what the files of a folder hold."""
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir()) if path.is_file()}


def test_an_unfinished_study_has_a_report_that_says_so(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    study.run()
    shutil.rmtree(study.out / "runs" / "toy" / "robot.odd=fine" / "2")
    assert main(["ablate", "--report", str(study.out)]) == 0
    assert "1 of 8 runs are pending" in capsys.readouterr().out
    assert main(["ablate", "--report", "nowhere"]) == 2
    assert (
        capsys.readouterr().err
        == "nowhere is not the folder of a study: there is no plan.json\n  name one that has it\n"
    )


def test_two_studies_are_paired_world_by_world(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    study.run()
    first = study.out.rename(study.out.with_name("first"))
    study.run("--set", "robot.times=2")
    capsys.readouterr()
    page = study.out.with_name("pair.md")
    assert main(["ablate", "--compare", str(first), str(study.out), "-o", str(page)]) == 0
    assert "robot.odd=fine" in capsys.readouterr().out
    assert "drive.way_m" in page.read_text()


def test_two_variants_are_contrasted_at_run_and_later(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    pair = "robot.odd=contact, robot.odd=fine"
    assert study.run("--contrast", pair) == 0
    at_run = capsys.readouterr().out
    title = "toy: robot.odd=contact (A), robot.odd=fine (B)"
    assert title in at_run
    assert "A better with" in at_run
    assert main(["ablate", "--report", str(study.out), "--contrast", pair]) == 0
    later = capsys.readouterr().out
    assert at_run[at_run.index(title) :] == later[later.index(title) :]
    assert main(["ablate", "--report", str(study.out), "--contrast", "robot.odd=contact,fine"]) == 2
    assert "the study has no variant 'fine'\n" in capsys.readouterr().err


def test_a_contrast_of_unknown_variants_runs_nothing(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    assert study.run("--contrast", "robot.odd=contact,robot.odd=fin") == 2
    assert "did you mean 'robot.odd=fine'?" in capsys.readouterr().err
    assert not study.out.exists()


def test_the_command_that_repeats_it_is_written_down(study: Any) -> None:
    words = study.words(seeds="0:1")
    main(words)
    assert json.loads((study.out / "plan.json").read_text())["command"] == " ".join(["graphnav", *words])
    assert " ".join(["graphnav", *words]) in (study.out / "report.html").read_text()
