"""Compare the variants of a study: means with intervals, paired differences from the base."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from graphnav.ablation.plan import Case, Plan
from graphnav.ablation.results.comparison import Comparison, Difference, Estimate, Row
from graphnav.ablation.results.intervals import difference_interval, mean_interval
from graphnav.ablation.results.metric_values import Values, is_binary, table_metrics, values_of
from graphnav.ablation.results.records import Record, in_plan_order
from graphnav.stage import Better


def compare(plan: Plan, records: Iterable[Record]) -> Comparison:
    """Return the table of a study: the plan's metrics, or all metrics where it names none.

    A world counts for a metric if its run has it, and for a difference if both runs have it: n is how many did. How
    failed runs count is described at `Record.counted`. A case that shares the base's runs has no differences, and a
    metric of the frames that a run meets has none where the two drive differently.
    """
    ordered = in_plan_order(plan, records)
    metrics = table_metrics(plan, ordered)
    by_case: dict[tuple[str, str], list[Record]] = {(case.graph, case.variant): [] for case in plan.cases}
    for record in ordered:
        by_case[record.graph, record.variant].append(record)
    values = {key: {metric.text: values_of(plan, metric, runs) for metric in metrics} for key, runs in by_case.items()}
    binary = {
        metric.text for metric in metrics if is_binary(plan, metric, (found[metric.text] for found in values.values()))
    }
    bases = {case.graph: case for case in plan.cases if case.is_base}
    return Comparison(
        tuple(
            _row(
                plan,
                case,
                by_case[case.graph, case.variant],
                values[case.graph, case.variant],
                None if case.folder == (base := bases[case.graph]).folder else values[base.graph, base.variant],
                binary,
                frozenset(
                    name for name in values[case.graph, case.variant] if not plan.are_comparable(case, base, name)
                ),
            )
            for case in plan.cases
        )
    )


def estimate(values: Values, *, is_binary: bool) -> Estimate:
    """Return the mean of at least one world with its interval."""
    array = np.array(list(values.values()))
    return Estimate(float(array.mean()), *mean_interval(array, is_binary=is_binary), array.size)


def difference(values: Values, base: Values, better: Better, *, is_binary: bool) -> Difference | None:
    """Return how ``values`` differ from ``base`` in the worlds that both have; None if they share none."""
    seeds = [seed for seed in values if seed in base]
    if not seeds:
        return None
    this, that = (np.array([column[seed] for seed in seeds]) for column in (values, base))
    more, less = int(np.count_nonzero(this > that)), int(np.count_nonzero(this < that))
    won, lost = (less, more) if better == "lower" else (more, less)
    interval = difference_interval(this, that, is_binary=is_binary)
    return Difference(float((this - that).mean()), *interval, len(seeds), won, lost)


def _row(
    plan: Plan,
    case: Case,
    runs: Sequence[Record],
    values: Mapping[str, Values],
    base: Mapping[str, Values] | None,
    binary: set[str],
    own_frames: frozenset[str],
) -> Row:
    differences = {
        metric: difference(column, base[metric], plan.better(metric), is_binary=metric in binary)
        for metric, column in values.items()
        if base is not None and metric not in own_frames
    }
    times: dict[str, list[float]] = {}
    for run in runs:
        for stage, time in run.times.items():
            times.setdefault(stage, []).append(time.p50_ms)
    return Row(
        case=case,
        runs=len(runs),
        outcomes=Counter(run.outcome for run in runs),
        failures=Counter(run.cause for run in runs if run.cause),
        estimates={metric: estimate(column, is_binary=metric in binary) for metric, column in values.items() if column},
        differences={metric: found for metric, found in differences.items() if found is not None},
        p50_ms={stage: float(np.median(found)) for stage, found in times.items()},
        own_frames=own_frames,
    )
