"""A run in several processes has the log of one process, byte for byte, and fails as it does."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import graphnav
from graphnav.core.catalog import Catalog
from graphnav.core.graph import load_graph
from graphnav.core.run_folder import RunFolder
from tests.processes.conftest import LATE_ANSWERS, STAGES, STEPS, Runs, steps_graph

PARTS = "deploy: {left: {stages: [clock, second, open]}, right: {stages: [fast, third]}}"
NUMPY_FIRST = """
import numpy
import graphnav
print(graphnav.run("steps.yaml", processes=True, plugins=[{stages!r}], pictures=False).summary.outcome)
"""
OTHER_PARTS = "deploy: {one: {stages: [slow, first, even]}, other: {stages: [both]}}"


@pytest.mark.long
@pytest.mark.parametrize(("name", "until_s"), [("corridor_ccw", 0.8), ("navigate", 0.8)])
def test_shipped_graphs_with_a_process_for_each_stage(runs: Runs, name: str, until_s: float) -> None:
    graph = load_graph(name, Catalog())
    graph = replace(graph, run=replace(graph.run, until_s=until_s))
    in_one, in_many = runs(graph), runs(graph.with_processes())
    assert in_many.agrees_with(in_one)
    assert len(in_many.summary.processes or ()) == len(graph.nodes)


@pytest.mark.parametrize("deploy", [PARTS, OTHER_PARTS], ids=["sources-apart", "sources-here"])
def test_some_stages_in_two_processes_and_the_others_here(runs: Runs, tmp_path: Path, deploy: str) -> None:
    in_one = runs(steps_graph(tmp_path))
    assert in_one.summary.outcome == "goal"
    assert in_one.summary.stages["both"].dropped > 0
    assert runs(steps_graph(tmp_path, deploy)).agrees_with(in_one)


def test_from_python_every_stage_gets_a_process(tmp_path: Path) -> None:
    path = tmp_path / "steps.yaml"
    path.write_text(STEPS.format(deploy="", first="{}", third="{}", more=""))
    options: dict[str, Any] = {"plugins": [STAGES], "pictures": False}
    in_one, in_many = (graphnav.run(path, processes=processes, **options) for processes in (False, True))
    assert (in_many.folder / RunFolder.LOG).read_bytes() == (in_one.folder / RunFolder.LOG).read_bytes()
    assert len(in_many.summary.processes or ()) == 9


def test_a_program_that_has_loaded_numpy_before_runs_over_processes_too(tmp_path: Path) -> None:
    """Numpy has chosen its code by the CPU then, and so do the processes."""
    (tmp_path / "steps.yaml").write_text(STEPS.format(deploy="", first="{}", third="{}", more=""))
    (tmp_path / "program.py").write_text(NUMPY_FIRST.format(stages=str(STAGES)))
    program = [sys.executable, "program.py"]
    done = subprocess.run(program, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.stdout, done.returncode) == ("goal\n", 0), done.stderr


def test_stages_that_do_not_wait_for_each_other_step_side_by_side(runs: Runs, tmp_path: Path) -> None:
    files = tmp_path / "one", tmp_path / "other"
    first, last = (f"{{at: 2, what: meet, file: {mine}, other: {its}}}" for mine, its in (files, files[::-1]))
    more = f"  last: {{use: steps.pass, in: {{one: clock}}, with: {last}}}\n"
    deploy = "deploy: {left: {stages: [first]}, right: {stages: [last]}}"
    assert runs(steps_graph(tmp_path, deploy, first=first, more=more)).summary.outcome == "goal"


def test_answers_that_come_late_and_in_any_order_change_nothing(runs: Runs, tmp_path: Path) -> None:
    in_one, graph = runs(steps_graph(tmp_path)), steps_graph(tmp_path).with_processes()
    assert runs(replace(graph, plugins=(STAGES, LATE_ANSWERS))).agrees_with(in_one)


@pytest.mark.parametrize(
    "options",
    [
        {"first": "{at: 7, what: fail}"},
        {"third": "{at: 7, what: fail}"},
        {"third": "{at: 3, what: nan}"},
        {"first": "{what: fail}", "third": "{what: fail}"},
        {"first": "{what: close}", "third": "{what: close}"},
        {"more": "  last: {use: steps.pass, in: {one: second.late}}\n"},
    ],
    ids=["step-here", "step", "not-finite", "reset", "close", "own-stamp"],
)
def test_a_stage_fails_as_in_one_process(runs: Runs, tmp_path: Path, options: Mapping[str, str]) -> None:
    in_one, in_many = runs(steps_graph(tmp_path, **options)), runs(steps_graph(tmp_path, PARTS, **options))
    assert in_one.summary.outcome == "failed"
    assert in_many.agrees_with(in_one)
    assert list(map(str, in_many.errors)) == list(map(str, in_one.errors))
    assert [error.__cause__ is None for error in in_many.errors] == [e.__cause__ is None for e in in_one.errors]


def test_what_a_stage_prints_is_shown_with_the_name_of_its_process_and_kept(runs: Runs, tmp_path: Path) -> None:
    ran = runs(steps_graph(tmp_path, PARTS, third="{at: 2, what: print}"))
    assert ran.notices == ["[right] step 2\x1b[2J"]
    assert (ran.folder / "processes" / "right.txt").read_text() == "step 2\x1b[2J\n"
