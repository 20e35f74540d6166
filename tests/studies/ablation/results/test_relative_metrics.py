"""Metrics relative to the reference's run in the same world."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from graphnav.core.stage import Metric
from graphnav.studies.ablation.plan.plan import Plan
from graphnav.studies.ablation.report.legend import counting
from graphnav.studies.ablation.results.compare_variants import compare
from graphnav.studies.ablation.results.records import Record, read_records, relative_metrics

MakePlan = Callable[..., Plan]
MakeRecord = Callable[..., Record]

NAME = "drive.oracle_spl"
OF_ORACLE = Metric("oracle_spl", help="x", better="higher", if_failed=0.0, relative_to="path_length_m", bounds=(0, 1))


@pytest.fixture
def plan(make_plan: MakePlan) -> Plan:
    plan = make_plan(variants=("ica", "affine", "oracle"), metrics={"drive.success": "higher"})
    return dataclasses.replace(plan, declared={**plan.declared, NAME: OF_ORACLE}, reference="oracle")


def arrived(path_m: float) -> dict[str, float]:
    return {"drive.success": 1.0, "drive.path_length_m": path_m}


LOST = {"drive.success": 0.0}


def test_it_is_the_references_path_over_the_longer_one(plan: Plan, make_record: MakeRecord) -> None:
    runs = [
        make_record("ica", 0, arrived(12.0)),
        make_record("affine", 0, arrived(8.0)),
        make_record("oracle", 0, arrived(10.0)),
        make_record("ica", 1, LOST, outcome="contact"),
        make_record("affine", 1, {"drive.path_length_m": 1.0}, outcome="failed"),
        make_record("oracle", 1, arrived(10.0)),
    ]
    found = [metrics.get(NAME) for metrics in relative_metrics(plan, runs)]
    assert found == pytest.approx([10 / 12, 1.0, 1.0, 0.0, 0.0, 1.0])


def test_a_world_in_which_the_reference_did_not_arrive_has_none(plan: Plan, make_record: MakeRecord) -> None:
    runs = [
        make_record("ica", 0, arrived(12.0)),
        make_record("oracle", 0, LOST, outcome="timeout"),
        make_record("ica", 1, arrived(12.0)),
        make_record("ica", 2, {}, outcome="failed"),
        make_record("oracle", 2, {}, outcome="failed"),
    ]
    assert relative_metrics(plan, runs) == [{}] * 5
    assert make_record("ica", 2, {}, outcome="failed").counted(NAME, OF_ORACLE) is None


def test_an_integer_counts_as_a_number(plan: Plan, make_record: MakeRecord) -> None:
    plan = dataclasses.replace(
        plan, declared={**plan.declared, NAME: dataclasses.replace(OF_ORACLE, if_failed=0)}, metrics=(NAME,)
    )
    runs = [make_record("ica", 0, LOST, outcome="contact"), make_record("oracle", 0, arrived(10.0))]
    assert relative_metrics(plan, runs) == [{NAME: 0}, {NAME: 1.0}]
    success = dataclasses.replace(plan.declared["drive.success"], if_failed=0)
    assert make_record("ica", 0, LOST, outcome="failed").counted("drive.success", success) == 0
    assert "counts as drive.oracle_spl 0" in counting(plan, [NAME])


def test_without_a_reference_no_run_has_it(plan: Plan, make_record: MakeRecord) -> None:
    runs = [make_record("ica", 0, arrived(12.0)), make_record("oracle", 0, arrived(10.0))]
    assert relative_metrics(dataclasses.replace(plan, reference=""), runs) == [{}, {}]


def test_it_is_read_with_the_runs_and_compared_like_any_other(plan: Plan, tmp_path: Path) -> None:
    paths: Mapping[str, tuple[float, float]] = {"ica": (12.5, 10.0), "affine": (20.0, 10.0), "oracle": (10.0, 10.0)}
    for variant, lengths in paths.items():
        for seed, path_m in enumerate(lengths):
            write_run(tmp_path / "corridor" / variant / str(seed), path_m)
    plan = dataclasses.replace(plan, metrics=(NAME,))
    comparison = compare(plan, read_records(plan, tmp_path))
    assert [row.estimates[NAME].mean for row in comparison.rows] == pytest.approx([0.9, 0.75, 1.0])
    assert comparison.rows[1].differences[NAME].mean == pytest.approx(-0.15)


def write_run(folder: Path, path_m: float) -> None:
    folder.mkdir(parents=True)
    scores = {"drive": {"success": 1.0, "path_length_m": path_m}}
    summary = {"outcome": "goal", "failure": "", "frames": 1, "sim_s": 1, "wall_s": 1, "stages": {}, "scores": scores}
    (folder / "summary.json").write_text(json.dumps(summary))
