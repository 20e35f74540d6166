"""Compare the variants of a study: means with intervals, paired differences from the base."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from graphnav.studies.ablation.plan import Case, Job, Plan
from graphnav.studies.ablation.results.comparison import Comparison, Row, as_family
from graphnav.studies.ablation.results.records import Record
from graphnav.studies.ablation.results.study_values import StudyValues, key_of


def compare(plan: Plan, records: Iterable[Record], pending: Iterable[Job] = ()) -> Comparison:
    """Return the table of a study: the plan's metrics, or all metrics where it names none.

    A world counts for a metric if its run has it, and for a difference if both runs have it: n is how many did. How
    failed runs count is described at `Record.counted`. A case that shares the base's runs has no differences, and a
    metric of the frames that a run meets has none where the two drive differently. All variants of a graph that may be
    compared with the base by the metric that decides, under one condition, are one family of comparisons. ``pending``:
    the runs that are still to be made.
    """
    study = StudyValues.of(plan, records)
    missing = Counter(job.case.folder for job in pending)
    primary = study.primary
    bases = {case.graph: case for case in plan.cases if case.is_base}
    rows = []
    for graph in plan.graphs:
        of_graph = [_row(study, case, bases[graph], missing) for case in plan.cases if case.graph == graph]
        rows += of_graph if primary is None else _judged(of_graph, primary, bases[graph])
    places = {key_of(case): place for place, case in enumerate(plan.cases)}
    return Comparison(tuple(sorted(rows, key=lambda row: places[key_of(row.case)])), primary)


def _judged(rows: Sequence[Row], primary: str, base: Case) -> list[Row]:
    """Return the rows of one graph with the significance of the differences by the metric that decides."""
    family = {row.case.folder for row in rows if primary not in row.own_frames} - {base.folder}
    known = {row.case.folder: row.differences[primary] for row in rows if primary in row.differences}
    judged = dict(zip(known, as_family(list(known.values()), len(family)), strict=True))
    return [
        replace(row, differences={**row.differences, primary: judged[row.case.folder]})
        if primary in row.differences
        else row
        for row in rows
    ]


def _row(study: StudyValues, case: Case, base: Case, missing: Mapping[str, int]) -> Row:
    key = key_of(case)
    runs = study.runs[key]
    own_frames = frozenset(name for name in study.metrics if not study.plan.are_comparable(case, base, name))
    estimates = {metric: study.estimate(key, metric) for metric in study.metrics}
    differences = {
        metric: study.difference(key, key_of(base), metric) for metric in study.metrics if case.folder != base.folder
    }
    times: dict[str, list[float]] = {}
    for run in runs:
        for stage, time in run.times.items():
            times.setdefault(stage, []).append(time.p50_ms)
    return Row(
        case=case,
        runs=len(runs),
        pending=missing.get(case.folder, 0),
        outcomes=Counter(run.outcome for run in runs),
        failures=Counter(run.cause for run in runs if run.cause),
        estimates={metric: found for metric, found in estimates.items() if found is not None},
        differences={metric: found for metric, found in differences.items() if found is not None},
        p50_ms={stage: float(np.median(found)) for stage, found in times.items()},
        own_frames=own_frames,
    )
