"""Metrics of the frames that a run meets are compared only where two variants drive alike."""

import dataclasses
import io
from collections.abc import Callable
from pathlib import Path

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.errors import Problem
from graphnav.core.machine.console import Console
from graphnav.core.stage import Metric
from graphnav.studies.ablation.plan import check_study
from graphnav.studies.ablation.plan.plan import Plan
from graphnav.studies.ablation.report.markdown import table_markdown
from graphnav.studies.ablation.report.terminal import print_comparison
from graphnav.studies.ablation.results import compare
from graphnav.studies.ablation.results.comparison import Comparison
from graphnav.studies.ablation.results.records import Record
from graphnav.studies.ablation.study.command_line import study_of_command
from graphnav.studies.ablation.study.vary import parse_varies

MakePlan = Callable[..., Plan]
MakeRecord = Callable[..., Record]
CATALOG = Catalog()
METRICS = ("drive.success", "sight.auroc")


def drives(graph: str, *varies: str, within: tuple[str, ...] = ()) -> list[str]:
    """Return whose drive each case has."""
    problems: list[Problem] = []
    axes = parse_varies(varies, problems)
    study = study_of_command([graph], varies=axes, seeds="0:2", within=within, problems=problems)
    return [case.drives_as for case in check_study(study, CATALOG, "graphnav ablate ...").plan.cases]


@pytest.fixture
def compared(make_plan: MakePlan, make_record: MakeRecord) -> tuple[Plan, Comparison]:
    """Return a study of two variants that drive differently, and one that drives as the base does."""
    auroc = Metric("auroc", help="Area.", better="higher", of_frames=True)
    made = make_plan(("ica", "affine", "twin"), range(8), metrics=dict.fromkeys(METRICS, "higher"))
    alike = {"ica": "ica", "affine": "affine", "twin": "ica"}
    cases = tuple(dataclasses.replace(case, drives_as=alike[case.variant]) for case in made.cases)
    plan = dataclasses.replace(made, cases=cases, declared={**made.declared, "sight.auroc": auroc})
    values = {"ica": 0.5, "affine": 0.9, "twin": 0.8}
    records = [
        make_record(variant, seed, {"drive.success": 1.0, "sight.auroc": value + seed / 1000})
        for variant, value in values.items()
        for seed in range(8)
    ]
    return plan, compare(plan, records)


def test_it_is_reported_but_not_compared(compared: tuple[Plan, Comparison]) -> None:
    _, (base, affine, twin) = compared[0], compared[1].rows
    assert affine.estimates["sight.auroc"].n == 8
    assert set(affine.differences) == {"drive.success"}
    assert set(twin.differences) == set(METRICS)
    assert [sorted(row.own_frames) for row in (base, affine, twin)] == [[], ["sight.auroc"], []]


def test_tables_say_so(compared: tuple[Plan, Comparison]) -> None:
    text = table_markdown(*compared)
    assert text.count("| own frames |") == 1
    assert "Own frames: the variant drives differently" in text
    shown = io.StringIO()
    print_comparison(Console(file=shown, width=300), compared[1], compared[0])
    assert shown.getvalue().count("own frames") == 1


def test_detectors_that_drive_meet_their_own_frames() -> None:
    assert drives("corridor_ccw", "plane=plane.ica,plane.affine") == ["plane.ica", "plane.affine"]


def test_detectors_on_one_drive_meet_the_same_frames() -> None:
    assert drives("measure_detectors", "flow=flow.lucas_kanade,flow.dis") == ["flow.lucas_kanade"] * 2


def test_a_drive_by_true_data_does_not_depend_on_what_the_camera_shows() -> None:
    assert drives("measure_conditions", "robot.tilt_deg=75,35") == ["robot.tilt_deg=75"] * 2
    assert drives("corridor_ccw", "robot.tilt_deg=75,35") == ["robot.tilt_deg=75", "robot.tilt_deg=35"]


@pytest.mark.parametrize(
    "vary",
    [
        "robot.map=maps/corridor_ccw.yaml,maps/pillars.yaml",
        "robot.max_speed_mps=0.5,0.1",
        "robot.slip_ratio=0,0.2",
        "robot.rate_hz=10,5",
        "run.until_s=120,5",
    ],
)
def test_what_changes_the_drive_or_its_end_changes_its_frames(vary: str) -> None:
    assert len(set(drives("measure_conditions", vary))) == 2


@pytest.mark.parametrize(
    "vary", ["robot.contrast_ratio=1,0.5", "robot.odometry_noise_ratio=0,0.1", "robot.exposure_s=0,0.1"]
)
def test_what_only_the_measured_stages_read_does_not(vary: str) -> None:
    assert len(set(drives("measure_conditions", vary))) == 1


def test_a_drive_by_the_true_picture_depends_on_the_camera(tmp_path: Path) -> None:
    graph = tmp_path / "true_plane.yaml"
    stages = "plane: {use: plane.truth}, robot: {in: {command: control.twist}}, guard: null"
    graph.write_text(f"extends: corridor_ccw\nstages: {{{stages}}}\n")
    found = [len(set(drives(str(graph), vary))) for vary in ("robot.tilt_deg=75,35", "robot.noise_sigma_gray=2,8")]
    assert found == [2, 1]


def test_each_condition_has_its_own_drives() -> None:
    found = drives("corridor_ccw", "plane=plane.ica,plane.affine", "robot.tilt_deg=75,70", within=("robot.tilt_deg",))
    assert found == ["plane.ica", "plane.affine"] * 2
