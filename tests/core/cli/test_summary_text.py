"""The output of a run is complete on any terminal width."""

from __future__ import annotations

import io
from dataclasses import replace

import pytest

from graphnav.core.machine.console import Console
from graphnav.core.report.summary_text import NONE_DECLARED, Declared, print_summary
from graphnav.core.runner.recording.summary import StageSteps, Summary
from graphnav.core.stage import Metric

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


LATE = StageSteps(use="plane.ica", steps=9, p50_ms=9.0, p99_ms=12.0, dropped=0, missed=4)


def printed(summary: Summary, cols: int = 200, *, declared: Declared = NONE_DECLARED, is_verbose: bool = True) -> str:
    """Return what a run prints at its end."""
    file = io.StringIO()
    print_summary(Console(file=file, width=cols, soft_wrap=True), summary, declared, is_verbose=is_verbose)
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
    free = StageSteps(use="steer.pca", steps=8, p50_ms=1.0, p99_ms=2.0, dropped=0)
    lines = printed(replace(SUMMARY, stages={"plane": LATE, "steer": free})).splitlines()
    assert [line.split()[-1] for line in lines if line.startswith((" stage", " plane", " steer"))] == [
        "missed",
        "4",
        "0",
    ]


def test_a_run_opens_with_its_verdict_and_five_numbers() -> None:
    metrics = (
        Metric("frames", better="neither", help="Frames."),
        Metric("touched", better="lower", bounds=(0.0, 1.0), help="1 if it touched anything."),
        Metric("way_m", unit="m", better="lower", help="Way."),
        Metric("room_m", unit="m", better="higher", help="Room."),
        Metric("jerk", unit="m/s³", better="lower", help="Jerk."),
        Metric("spl", better="higher", bounds=(0.0, 1.0), is_key=True, help="Share."),
        Metric("absent_m", unit="m", better="higher", help="Left out."),
    )
    values = {"frames": 9.0, "touched": 0.0, "way_m": 3.25, "room_m": 0.5, "jerk": 2.0, "spl": 0.75}
    summary = replace(SUMMARY, scores={"drive": values}, stages={"plane": LATE})
    declared = {"drive": {metric.name: metric for metric in metrics}}
    verdict, *shown, missed, amount = printed(summary, declared=declared, is_verbose=False).splitlines()
    assert verdict == "goal reached after 123456.7 s"
    assert [line.split() for line in shown] == [
        ["drive.spl", "0.75"],
        ["drive.way_m", "3.25"],
        ["drive.room_m", "0.5"],
        ["drive.jerk", "[m/s³]", "2"],
        ["drive.frames", "9"],
    ]
    assert missed == "plane missed its deadline in 4 of 9 steps"
    assert amount.startswith("1234567 ticks, seed 7, ")
    said = printed(summary, declared=declared)
    assert said.startswith(f"{verdict}\n")
    assert "undefined in this run: drive.absent_m\n" in said


def test_a_narrow_terminal_gets_blocks_of_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "30")
    lines = printed(replace(SUMMARY, stages={"plane": LATE}), 30).splitlines()
    tables = [line for line in lines if line.startswith(" ")]
    assert max(map(len, tables)) <= 30
    assert {word for line in tables for word in line.split()} >= {"plane.ica", "steps", "9.00", "12.00", "missed", "4"}
    assert sum("plane.ica" in line for line in tables) > 1, "each block has the names"


@pytest.mark.parametrize(("ms", "said"), [(0.0, ["172"]), (22.0, ["172", "22.0", "22.0", "22.0"])])
def test_an_output_that_sent_only_stops_has_no_latency(ms: float, said: list[str]) -> None:
    times = {f"latency_{name}_ms": ms for name in ("p50", "p99", "max")}
    live = {"outputs": [{"name": "guard.twist", "channel": "BASE_CMD", "sent": 172, **times}]}
    (row,) = [line for line in printed(replace(SUMMARY, live=live)).splitlines() if "BASE_CMD" in line]
    assert row.split() == ["guard.twist", "BASE_CMD", *said]
