"""The gallery: which failures are shown, and that they happen again."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import pytest

from graphnav.core.stage import Metric
from graphnav.studies.ablation.execution.execute_jobs import pending_drawings
from graphnav.studies.ablation.execution.study_folder import StudyFolder, read_plan
from graphnav.studies.ablation.plan.plan import Plan
from graphnav.studies.ablation.results.records import Record, failure_folder, read_records, worst_failures

FAILURES = ["failures/toy/robot.odd=contact/0", "failures/toy/robot.odd=contact/1"]


def shown(study: Any) -> list[str]:
    return sorted(str(path.parent.relative_to(study.out)) for path in study.out.glob("failures/*/*/*/summary.json"))


def test_failures_are_run_again_with_everything_recorded(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    assert study.run("--gallery", "2") == 0
    assert shown(study) == FAILURES
    assert not list(study.out.glob("failures/**/*.lcmlog"))
    assert "not the same again" not in capsys.readouterr().out
    again = json.loads((study.out / FAILURES[0] / "summary.json").read_text())
    assert again["scores"] == study.summary("toy/robot.odd=contact/0")["scores"]
    before = (study.out / FAILURES[0] / "summary.json").stat().st_mtime_ns
    assert study.run("--gallery", "3") == 0
    assert len(shown(study)) == 3
    assert (study.out / FAILURES[0] / "summary.json").stat().st_mtime_ns == before


def test_their_logs_are_kept_where_that_is_asked(study: Any) -> None:
    study.run("--gallery", "1")
    study.run("--gallery", "1", "--keep-logs")
    assert [str(p.parent.relative_to(study.out)) for p in study.out.glob("failures/**/*.lcmlog")] == FAILURES[:1]
    assert "record: all" in (study.out / FAILURES[0] / "graph.yaml").read_text()


def test_one_that_does_not_happen_again_is_told(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    study.run()
    summary = study.out / "runs" / "toy" / "robot.odd=contact" / "0" / "summary.json"
    summary.write_text(summary.read_text().replace('"frames": 2', '"frames": 5'))
    capsys.readouterr()
    assert study.run("--gallery", "1") == 0
    said = "not the same again: runs/toy/robot.odd=contact/0: contact after 5 frames, but contact after 2 frames when"
    assert said in capsys.readouterr().out


@pytest.fixture
def plan(study: Any) -> Plan:
    """Return the plan of a study that was run."""
    study.run()
    plan = read_plan(study.out)
    success = Metric("success", help="Arrived.", better="higher", if_failed=0.0, is_outcome=True)
    return dataclasses.replace(plan, declared={**plan.declared, "drive.success": success})


def with_outcomes(records: tuple[Record, ...], **outcomes: str) -> list[Record]:
    """Return records that end as said by their seeds."""
    changed = []
    for record in records:
        outcome, _, frames = outcomes[f"s{record.seed}"].partition(" ")
        metrics = {"drive.success": 0.0} if frames == "lost" else {}
        count = 0 if frames == "unready" else 3
        changed.append(dataclasses.replace(record, outcome=outcome, frames=count, metrics=metrics))
    return changed


def test_contacts_come_before_breakdowns_before_timeouts(study: Any, plan: Plan) -> None:
    records = with_outcomes(read_records(plan, study.out), s0="timeout lost", s1="failed", s2="goal", s3="contact")
    assert [job.seed for job in worst_failures(plan, records, 2)] == [3, 1, 3, 1]
    assert [job.seed for job in worst_failures(plan, records, 9)] == [3, 1, 0, 3, 1, 0]
    assert worst_failures(plan, records, 0) == []


def test_an_end_of_time_without_a_goal_and_a_run_that_never_began_are_not_shown(study: Any, plan: Plan) -> None:
    records = with_outcomes(read_records(plan, study.out), s0="timeout", s1="failed unready", s2="end", s3="goal")
    assert worst_failures(plan, records, 9) == []


def test_a_baseline_is_shown_once(study: Any, plan: Plan) -> None:
    records = with_outcomes(read_records(plan, study.out), s0="contact", s1="contact", s2="contact", s3="contact")
    base, other = plan.cases
    baseline = dataclasses.replace(plan, cases=(base, dataclasses.replace(other, role="baseline")))
    chosen = worst_failures(baseline, records, 2)
    assert [failure_folder(job.case, job.seed) for job in chosen] == [
        "failures/toy/robot.odd=fine/0",
        "failures/toy/robot.odd=fine/1",
        "failures/toy/robot.odd=contact/0",
    ]
    with StudyFolder(study.out) as folder:
        assert pending_drawings(chosen, folder, keep_logs=False) == chosen


DRAWS_BADLY = """

@hookimpl
def graphnav_draw(recording, folder, video):
    (folder / "first.png").write_bytes(b"drawn")
    return [folder / "first.png"]


@hookimpl
def graphnav_draw_end(recording, file):
    raise ValueError("zero size,\\nin two lines")


@hookimpl
def graphnav_draw_paths(recordings, colours, file):
    raise ValueError("no <path>")
"""


def test_a_picture_that_cannot_be_drawn_costs_nothing_else(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    plugin = Path(study.plugin)
    plugin.write_text(plugin.read_text() + DRAWS_BADLY)
    said = "not drawn: runs/toy/robot.odd=contact/0: ValueError: zero size, in two lines (ValueError at "
    for _ in range(2):  # the same command tries again
        assert study.run("--gallery", "1") == 0
        assert said in capsys.readouterr().out
        assert len(study.rows) == 8
        assert (study.out / "table.md").is_file()
        report = (study.out / "report.html").read_text()
        assert "World 0 of toy cannot be drawn: ValueError: no &lt;path&gt;" in report
        assert (study.out / FAILURES[0] / "first.png").read_bytes() == b"drawn"
