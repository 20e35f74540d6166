"""What a run prints is whole, however narrow the terminal is."""

from __future__ import annotations

import io

import pytest
from rich.console import Console

from graphnav.report.table import print_summary
from graphnav.runner.summary import StageFigures, Summary


@pytest.mark.parametrize("cols", [20, 40, 80, 200])
def test_no_name_and_no_number_is_cut(cols: int) -> None:
    figures = StageFigures(use="control.nonholonomic", steps=1234567, p50_ms=1234.5, p99_ms=98765.4, dropped=7654321)
    summary = Summary(
        outcome="goal",
        failure="",
        graph="corridor",
        seed=7,
        until_s=None,
        frames=1234567,
        sim_s=123456.7,
        wall_s=1.0,
        stages={"a_stage_of_a_long_name": figures},
        scores={"sight": {"recall_at_5_false_alarms_ratio": 0.8781}},
        notices=[],
        tap_dropped=0,
        run_id="",
        versions={},
    )
    console = Console(file=io.StringIO(), width=cols, soft_wrap=True)
    print_summary(console, summary)
    assert isinstance(console.file, io.StringIO)
    said = console.file.getvalue()
    for word in ("a_stage_of_a_long_name", "control.nonholonomic", "1234.50", "98765.40", "7654321", "0.8781"):
        assert f" {word} " in said
    assert "recall_at_5_false_alarms_ratio" in said
