"""Summaries of runs, read back."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from graphnav.core.errors import UserError
from graphnav.core.runner.recording.summary import StageSteps, Summary
from graphnav.studies.ablation.plan.plan import Plan
from graphnav.studies.ablation.results.records import Record, in_plan_order, read_records

MakePlan = Callable[..., Plan]
MakeRecord = Callable[..., Record]


def write_run(folder: Path, scores: Mapping[str, Mapping[str, float]], outcome: str = "goal") -> Path:
    folder.mkdir(parents=True)
    path = folder / "summary.json"
    Summary(
        outcome=outcome,
        failure="",
        graph="corridor",
        seed=int(folder.name),
        until_s=None,
        frames=7,
        sim_s=0.6,
        wall_s=0.25,
        stages={"plane": StageSteps("plane.ica", 6, 0.5, 0.75, 0)},
        scores={stage: dict(metrics) for stage, metrics in scores.items()},
        notices=[],
        tap_dropped=0,
        run_id="",
        versions={},
    ).write(path)
    return path


def test_every_run_that_is_there_is_read_in_the_plans_order(make_plan: MakePlan, tmp_path: Path) -> None:
    plan = make_plan(variants=("ica", "affine", "twin"), graphs=("corridor", "pillars"), same_as={"twin": "affine"})
    for place in ("pillars/ica/1", "corridor/affine/2", "corridor/ica/0", "corridor/affine/0", "corridor/affine/9"):
        write_run(tmp_path / place, {"drive": {"spl": 0.5}})
    records = read_records(plan, tmp_path)
    assert [(record.graph, record.variant, record.seed, record.folder) for record in records] == [
        ("corridor", "ica", 0, "corridor/ica/0"),
        ("corridor", "affine", 0, "corridor/affine/0"),
        ("corridor", "affine", 2, "corridor/affine/2"),
        ("corridor", "twin", 0, "corridor/affine/0"),
        ("corridor", "twin", 2, "corridor/affine/2"),
        ("pillars", "ica", 1, "pillars/ica/1"),
    ]
    assert tuple(in_plan_order(plan, reversed(records))) == records


def test_a_record_is_what_the_summary_says(make_plan: MakePlan, tmp_path: Path) -> None:
    write_run(tmp_path / "corridor/ica/1", {"drive": {"spl": 1 / 3, "clearance_m": float("inf")}, "sight": {}})
    (record,) = read_records(make_plan(), tmp_path)
    assert (record.outcome, record.frames, record.sim_s, record.wall_s) == ("goal", 7, 0.6, 0.25)
    assert record.metrics == {"drive.spl": 1 / 3}, "what is not finite is missing"
    assert (record.times["plane"].steps, record.times["plane"].p50_ms, record.times["plane"].p99_ms) == (6, 0.5, 0.75)


def test_runs_that_were_stopped_are_not_there(make_plan: MakePlan, tmp_path: Path) -> None:
    write_run(tmp_path / "corridor/ica/1", {}, outcome="stopped")
    assert read_records(make_plan(), tmp_path) == ()


def test_nothing_was_run_yet(make_plan: MakePlan, tmp_path: Path) -> None:
    assert read_records(make_plan(), tmp_path / "nowhere") == ()


@pytest.mark.parametrize(
    "content",
    [b"", b"{", b'{"outcome": "goal"}', b"[]", b"\xff\xfe", b"null", b'{"outcome": "won"}'],
)
def test_summaries_that_are_none_are_all_named(make_plan: MakePlan, tmp_path: Path, content: bytes) -> None:
    plan = make_plan(variants=("ica", "affine", "twin"), same_as={"twin": "affine"})
    paths = [write_run(tmp_path / place, {}) for place in ("corridor/ica/0", "corridor/ica/1", "corridor/affine/2")]
    for path in paths[1:]:
        path.write_bytes(content)
    with pytest.raises(UserError) as caught:
        read_records(plan, tmp_path)
    assert len(caught.value.problems) == 2
    for path in paths[1:]:
        assert f"{path} is not a complete summary of a run\n  remove it" in str(caught.value)


def test_a_summary_cut_anywhere_is_noticed(make_plan: MakePlan, tmp_path: Path) -> None:
    path = write_run(tmp_path / "corridor/ica/1", {"drive": {"spl": 0.5}})
    complete = path.read_bytes()
    assert json.loads(complete)
    for length in range(0, len(complete) - 2, 37):
        path.write_bytes(complete[:length])
        with pytest.raises(UserError, match="not a complete summary"):
            read_records(make_plan(), tmp_path)


def test_a_failed_stage_never_improves_a_result(make_plan: MakePlan, make_record: MakeRecord) -> None:
    metrics = {"drive.success": 0.0, "drive.timeout": 1.0, "drive.duration_s": 0.2, "drive.spl": 0.0, "sight.iou": 0.9}
    plan = make_plan()
    failed = make_record("ica", 0, metrics, outcome="failed")
    for name in ("drive.success", "drive.spl"):
        assert failed.counted(name, plan.metric(name)) == 0.0
    for name in ("drive.timeout", "drive.duration_s", "sight.iou", "drive.collision", "drive.path_length_m"):
        assert failed.counted(name, plan.metric(name)) is None
    timeout = make_record("ica", 0, metrics, outcome="timeout")
    assert timeout.counted("drive.duration_s", plan.metric("drive.duration_s")) == 0.2


def test_a_stage_that_fails_before_the_first_frame_has_not_succeeded(
    make_plan: MakePlan, make_record: MakeRecord
) -> None:
    success = make_plan().metric("drive.success")
    assert make_record("ica", 0, {}, outcome="failed").counted("drive.success", success) == 0.0
    without_a_goal = make_record("ica", 0, {"drive.collision": 0.0}, outcome="failed")
    assert without_a_goal.counted("drive.success", success) is None
