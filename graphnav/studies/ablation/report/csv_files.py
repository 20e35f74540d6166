"""Tables for other programs: ``results.csv`` with the result of every run, ``metrics.csv``, and ``timing.csv``."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from pathlib import Path

from graphnav.core.machine.atomic_write import write_atomically
from graphnav.studies.ablation.plan import Plan
from graphnav.studies.ablation.results import Record, in_plan_order, metric_columns

RESULTS = "results.csv"
METRICS = "metrics.csv"
TIMING = "timing.csv"


def write_results(plan: Plan, records: Iterable[Record], path: Path) -> None:
    """Write a line a run and a column a metric; the same runs give the same bytes, in whatever order they were made.

    ``cause`` is the failure without its time: runs that failed alike have the same. Nothing that a wall clock measured
    is in it. Numbers are written so that reading them gives the same number back; a metric that a run does not have is
    empty.
    """
    ordered = in_plan_order(plan, records)
    metrics = metric_columns(plan, ordered)
    cases = {(case.graph, case.variant): case for case in plan.cases}
    columns = ("seed", "outcome", "cause", "failure", "frames", "sim_s")
    header = ["graph", "variant", "role", *plan.axes, *columns, *metrics]
    rows = (
        [
            (case := cases[record.graph, record.variant]).source,
            record.variant,
            case.role,
            *(case.labels.get(axis, "") for axis in plan.axes),
            record.seed,
            record.outcome,
            record.cause,
            record.failure,
            record.frames,
            repr(record.sim_s),
            *(repr(record.metrics[name]) if name in record.metrics else "" for name in metrics),
        ]
        for record in ordered
    )
    _write(path, header, rows)


def write_metrics(plan: Plan, records: Iterable[Record], path: Path) -> None:
    """Write what is declared of each metric in ``results.csv``, a line a column: unit, direction, what counts, help."""
    names = metric_columns(plan, in_plan_order(plan, records))
    declared = {name: plan.metric(name) for name in names}
    header = ["metric", "unit", "better", "if_failed", "outcome", "min_difference", "help"]
    rows = (
        [name, m.unit, m.better, m.if_failed, m.is_outcome, repr(m.min_difference), m.help]
        for name, m in declared.items()
    )
    _write(path, header, rows)


def write_timing(plan: Plan, records: Iterable[Record], path: Path) -> None:
    """Write a line for every stage of every run: what it was, how often it stepped, how long that took."""
    cases = {(case.graph, case.variant): case for case in plan.cases}
    header = ["graph", "variant", *plan.axes, "seed", "wall_s", "stage", "use", "steps", "p50_ms", "p99_ms"]
    rows = (
        [
            (case := cases[record.graph, record.variant]).source,
            record.variant,
            *(case.labels.get(axis, "") for axis in plan.axes),
            record.seed,
            repr(record.wall_s),
            stage,
            case.uses.get(stage, ""),
            time.steps,
            repr(time.p50_ms),
            repr(time.p99_ms),
        ]
        for record in in_plan_order(plan, records)
        for stage, time in record.times.items()
    )
    _write(path, header, rows)


def _write(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    write_atomically(path, text.getvalue())
