"""The graph of a case is loaded once in the process that asks for a study, and once in each that makes runs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import graphnav
from graphnav.core.catalog import Catalog
from graphnav.core.graph import Graph, Override, load
from graphnav.core.graph.check import check
from graphnav.core.spec import Spec
from graphnav.studies.ablation.execution.execute_jobs import TaskFactory
from graphnav.studies.ablation.plan import check_study
from graphnav.studies.ablation.study import parse_varies, study_of_command
from graphnav.studies.ablation.worker.perform_task import perform

FEW = {"run.until_s": 0.2}
RIVALS = ["plane.ica", "plane.affine", "plane.homography"]

Loads = Callable[[], int]


@pytest.fixture
def loads(monkeypatch: pytest.MonkeyPatch) -> Loads:
    """Return what says how often a graph was checked in this process so far."""
    checked: list[Path] = []

    def counted(spec: Spec, catalog: Catalog, path: Path, *more: Any) -> Graph:
        checked.append(path)
        return check(spec, catalog, path, *more)

    monkeypatch.setattr(load, "check", counted)
    return lambda: len(checked)


def test_a_study_loads_the_graph_of_each_case_once(loads: Loads, tmp_path: Path) -> None:
    study = graphnav.ablate(
        "corridor_ccw", vary={"plane": RIVALS}, set=FEW, seeds=[0, 1], jobs=1, gallery=0, folder=tmp_path
    )
    assert len(study.records) == 6
    assert loads() == 3


def test_a_worker_loads_the_graph_of_a_case_once(loads: Loads, tmp_path: Path) -> None:
    varies = parse_varies([f"plane={','.join(RIVALS[:2])}"], [])
    overrides = [Override.parse("run.until_s=0.2")]
    study = study_of_command(["corridor_ccw"], varies=varies, overrides=overrides, seeds="0:3")
    checked = check_study(study, Catalog(), "")
    tasks, before = TaskFactory(checked), loads()
    for number, job in enumerate(checked.plan.jobs):
        scratch = tmp_path / str(number)
        scratch.mkdir()
        assert perform(tasks.task(job), scratch).outcome == "timeout"
    assert loads() - before == 2
