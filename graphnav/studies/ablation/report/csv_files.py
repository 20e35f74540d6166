"""Tables for other programs: ``results.csv`` with the result of every run, ``metrics.csv``, and ``timing.csv``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from graphnav.core.machine import write_atomically
from graphnav.core.tables import Table
from graphnav.studies.ablation.plan import Case, Plan
from graphnav.studies.ablation.results import Record, in_plan_order, metric_columns

RESULTS = "results.csv"
METRICS = "metrics.csv"
TIMING = "timing.csv"


def runs_data(plan: Plan, records: Iterable[Record]) -> Table:
    """Return a row a run and a column a metric; the same of the same runs, in whatever order they were made.

    ``cause`` is the failure without its time: runs that failed alike have the same. Nothing that a wall clock measured
    is in it.
    """
    ordered = in_plan_order(plan, records)
    metrics = metric_columns(plan, ordered)
    columns = ("seed", "outcome", "cause", "failure", "frames", "sim_s")
    rows = [
        [
            case.source,
            record.variant,
            case.role,
            *map(case.labels.get, plan.axes),
            *(getattr(record, column) for column in columns),
            *map(record.metrics.get, metrics),
        ]
        for case, record in _with_cases(plan, ordered)
    ]
    return Table.plain(["graph", "variant", "role", *plan.axes, *columns, *metrics], rows)


def metrics_data(plan: Plan, records: Iterable[Record]) -> Table:
    """Return what is declared of each metric in ``results.csv``, a row a column: unit, direction, what counts, help."""
    names = metric_columns(plan, in_plan_order(plan, records))
    rows = [
        [name, m.unit, m.better, m.if_failed, m.is_outcome, m.min_difference, m.help]
        for name, m in zip(names, map(plan.metric, names), strict=True)
    ]
    return Table.plain(["metric", "unit", "better", "if_failed", "outcome", "min_difference", "help"], rows)


def timing_data(plan: Plan, records: Iterable[Record]) -> Table:
    """Return a row for every stage of every run: what it was, how often it stepped, how long that took."""
    rows = [
        [
            case.source,
            record.variant,
            *map(case.labels.get, plan.axes),
            record.seed,
            record.wall_s,
            stage,
            case.uses.get(stage),
            time.steps,
            time.p50_ms,
            time.p99_ms,
        ]
        for case, record in _with_cases(plan, in_plan_order(plan, records))
        for stage, time in record.times.items()
    ]
    return Table.plain(
        ["graph", "variant", *plan.axes, "seed", "wall_s", "stage", "use", "steps", "p50_ms", "p99_ms"], rows
    )


def write_csv_files(plan: Plan, records: Iterable[Record], folder: Path) -> None:
    """Write the three files into the folder of a study.

    Raises
    ------
    GraphnavError
        The disk refuses; an existing file is unchanged.
    """
    found = tuple(records)
    for name, data_of in ((RESULTS, runs_data), (METRICS, metrics_data), (TIMING, timing_data)):
        write_atomically(folder / name, data_of(plan, found).csv_text())


def _with_cases(plan: Plan, records: Iterable[Record]) -> Iterator[tuple[Case, Record]]:
    cases = {(case.graph, case.variant): case for case in plan.cases}
    for record in records:
        yield cases[record.graph, record.variant], record
