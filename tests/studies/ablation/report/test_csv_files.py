"""The files for other programs."""

from __future__ import annotations

import csv
import random
from collections.abc import Callable
from pathlib import Path

import pytest

from graphnav.studies.ablation.plan.plan import Plan
from graphnav.studies.ablation.report.csv_files import runs_data, write_csv_files
from graphnav.studies.ablation.results.records import Record
from graphnav.studies.ablation.results.study_values import metric_columns

MakePlan = Callable[..., Plan]
MakeRecord = Callable[..., Record]


def lines(path: Path) -> list[list[str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.reader(file))


def test_a_line_a_run_and_a_column_a_metric(make_plan: MakePlan, make_record: MakeRecord, tmp_path: Path) -> None:
    plan = make_plan(metrics={"drive.spl": "higher", "a.x / b.x": "higher"})
    records = [
        make_record("ica", 0, {"a.x": 1 / 3, "drive.success": 1.0, "drive.spl": 0.5, "b.x": 2.0}),
        make_record("affine", 2, {"drive.spl": 1e-30}, outcome="failed", failure='no "plane",\nnone at all'),
    ]
    write_csv_files(plan, records, tmp_path)
    header, first, second = lines(tmp_path / "results.csv")
    assert header[:7] == ["graph", "variant", "role", "plane", "seed", "outcome", "cause"]
    assert header[7:10] == ["failure", "frames", "sim_s"]
    assert header[10:] == ["drive.spl", "a.x", "b.x", "drive.success"], "the study's metrics first"
    assert first == [
        "corridor",
        "ica",
        "method",
        "ica",
        "0",
        "goal",
        "",
        "",
        "10",
        "0.9",
        "0.5",
        repr(1 / 3),
        "2.0",
        "1.0",
    ]
    assert second[5] == "failed"
    assert second[6:8] == ['no "plane",\nnone at all'] * 2
    assert second[10:] == ["1e-30", "", "", ""]


@pytest.mark.parametrize("seed", range(10))
def test_the_order_of_runs_does_not_count(make_plan: MakePlan, make_record: MakeRecord, seed: int) -> None:
    rng = random.Random(seed)
    plan = make_plan(graphs=("pillars", "corridor"), seeds=(7, 3, 5))
    records = [
        make_record(variant, world, {f"drive.{name}": rng.random() for name in rng.sample("abcde", 3)}, graph=graph)
        for graph in plan.graphs
        for variant in plan.variants
        for world in plan.seeds
    ]
    expected = runs_data(plan, records).csv_text()
    rng.shuffle(records)
    assert runs_data(plan, records).csv_text() == expected
    assert "\r" not in expected
    assert [line.partition(",")[0] for line in expected.splitlines()[1::6]] == ["pillars", "corridor"]


def test_a_file_that_is_there_is_replaced(make_plan: MakePlan, make_record: MakeRecord, tmp_path: Path) -> None:
    path = tmp_path / "results.csv"
    path.write_text("old\n" * 100)
    write_csv_files(make_plan(), [make_record("ica", 0)], tmp_path)
    assert len(lines(path)) == 2
    names = sorted(file.name for file in tmp_path.iterdir())
    assert names == ["metrics.csv", "results.csv", "timing.csv"], "nothing is left over"


def test_metrics_of_derived_columns_come_as_what_they_are_made_of(make_plan: MakePlan, make_record: MakeRecord) -> None:
    plan = make_plan(metrics={"a.x - b.x": "higher", "c.never": "higher"})
    records = [make_record("ica", 0, {"z.z": 0.0, "b.x": 0.0, "a.x": 0.0})]
    assert metric_columns(plan, records) == ("a.x", "b.x", "z.z")


def test_times_stand_apart(make_plan: MakePlan, make_record: MakeRecord, tmp_path: Path) -> None:
    write_csv_files(make_plan(), [make_record("affine", 1, p50_ms=0.25)], tmp_path)
    header, line = lines(tmp_path / "timing.csv")
    assert dict(zip(header, line, strict=True)) == {
        "graph": "corridor",
        "variant": "affine",
        "plane": "affine",
        "seed": "1",
        "wall_s": "0.1",
        "stage": "plane",
        "use": "plane.affine",
        "steps": "9",
        "p50_ms": "0.25",
        "p99_ms": "0.5",
    }


def test_every_column_of_the_results_is_described(make_plan: MakePlan, make_record: MakeRecord, tmp_path: Path) -> None:
    plan = make_plan(metrics={"drive.path_length_m": "lower", "drive.success": "higher"})
    records = [make_record("ica", 0, {"drive.success": 1.0, "drive.path_length_m": 3.0, "a.x": 1.0})]
    write_csv_files(plan, records, tmp_path)
    described = lines(tmp_path / "metrics.csv")
    assert described[1] == ["drive.path_length_m", "m", "lower", "undefined", "False", "0.0", "Path."]
    assert described[2] == ["drive.success", "", "higher", "0.0", "True", "0.05", "Arrived."]
    assert [name for name, *_ in described[1:]] == lines(tmp_path / "results.csv")[0][10:]
