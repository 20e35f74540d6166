"""The output of a run is complete on any terminal width."""

from __future__ import annotations

import io
from dataclasses import replace

import pytest

from graphnav.machine.console import Console
from graphnav.report.table import print_summary
from graphnav.runner.recording.summary import StageSteps, Summary

SUMMARY = Summary(
    outcome="goal",
    failure="",
    graph="corridor",
    seed=7,
    until_s=None,
    frames=1234567,
    sim_s=123456.7,
    wall_s=1.0,
    stages={},
    scores={},
    notices=[],
    tap_dropped=0,
    run_id="",
    versions={},
)


def printed(summary: Summary, cols: int = 200) -> str:
    """Return what a run prints at its end."""
    file = io.StringIO()
    print_summary(Console(file=file, width=cols, soft_wrap=True), summary)
    return file.getvalue()


@pytest.mark.parametrize("cols", [20, 40, 80, 200])
def test_no_name_and_no_number_is_cut(cols: int) -> None:
    did = StageSteps(use="control.nonholonomic", steps=1234567, p50_ms=1234.5, p99_ms=98765.4, dropped=7654321)
    summary = replace(
        SUMMARY,
        stages={"a_stage_of_a_long_name": did},
        scores={"sight": {"recall_at_5_false_alarms_ratio": 0.8781}},
    )
    said = printed(summary, cols)
    assert "missed" not in said
    assert "behind" not in said
    for word in ("a_stage_of_a_long_name", "control.nonholonomic", "1234.50", "98765.40", "7654321", "0.8781"):
        assert f" {word} " in said
    assert "recall_at_5_false_alarms_ratio" in said


@pytest.mark.parametrize(
    ("behind_s", "said"), [(8.96, "of wall time (1234567 ticks/s), 9.0 s behind the wall clock\n"), (0.5, "ticks/s)\n")]
)
def test_a_paced_run_tells_how_late_it_was(behind_s: float, said: str) -> None:
    assert said in printed(replace(SUMMARY, behind_s=behind_s))


def test_missed_deadlines_are_a_column() -> None:
    late = StageSteps(use="plane.ica", steps=9, p50_ms=9.0, p99_ms=12.0, dropped=0, missed=4)
    free = StageSteps(use="steer.pca", steps=8, p50_ms=1.0, p99_ms=2.0, dropped=0)
    lines = printed(replace(SUMMARY, stages={"plane": late, "steer": free})).splitlines()
    assert [line.split()[-1] for line in lines if line.startswith((" stage", " plane", " steer"))] == [
        "missed",
        "4",
        "0",
    ]
