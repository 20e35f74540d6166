"""The metrics of a study, and their values run by run."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import partial

import numpy as np

from graphnav.arrays import Doubles
from graphnav.core.errors import GraphnavError
from graphnav.studies.ablation.plan import Plan
from graphnav.studies.ablation.results.comparison import Comparison
from graphnav.studies.ablation.results.records import Record
from graphnav.studies.ablation.study import MetricExpression

Values = Mapping[int, float]
"""One case's values of a metric, by seed: the seed is the world."""


def metric_columns(plan: Plan, records: Iterable[Record]) -> tuple[str, ...]:
    """Return every ``stage.metric`` that a record has: the plan's own first, then as they appear in the records."""
    found = dict.fromkeys(name for record in records for name in record.metrics)
    wanted = (name for text in plan.metrics for name in MetricExpression.parse(text).operands)
    return tuple(dict.fromkeys([*(name for name in wanted if name in found), *found]))


def table_metrics(plan: Plan, records: Sequence[Record]) -> tuple[MetricExpression, ...]:
    """Return the columns of a study's table."""
    return tuple(map(MetricExpression.parse, plan.metrics or metric_columns(plan, records)))


def values_of(plan: Plan, metric: MetricExpression, runs: Iterable[Record]) -> Values:
    """Return a metric of every run that has it, by seed."""
    found = ((run.seed, metric.value(partial(_counted, plan, run))) for run in runs)
    return {seed: value for seed, value in found if value is not None}


def _counted(plan: Plan, run: Record, name: str) -> float | None:
    return run.counted(name, plan.metric(name))


def scaled_values(plan: Plan, metric: str, graph: str, variant: str, values: Values) -> Values:
    """Return a metric with two bounds as a share of their distance, from 0 to 1.

    Raises
    ------
    GraphnavError
        A value is outside of the bounds that its stage declares.
    """
    low, high = plan.metric(metric).limits or (0.0, 1.0)
    for seed, value in values.items():
        if not low <= value <= high:
            what = f"{graph}, {variant}, seed {seed}: {metric} is {value:g}, outside of its bounds {low:g} to {high:g}"
            raise GraphnavError(f"{what}\n  correct the bounds that its stage declares")
    return {seed: (value - low) / (high - low) for seed, value in values.items()}


def paired_differences(values: Values, base: Values) -> Doubles:
    """Return ``values - base`` in the worlds that both have."""
    return np.array([value - base[seed] for seed, value in values.items() if seed in base])


def is_binary(plan: Plan, metric: MetricExpression, columns: Iterable[Values]) -> bool:
    """Return whether a metric is 0 or 1 wherever it is known and is meant to be.

    No difference and no ratio of metrics is, and nothing with a unit: an error may be 0 px in every world.
    """
    return not (metric.operator or plan.metric(metric.text).unit) and all(
        value in (0.0, 1.0) for column in columns for value in column.values()
    )


def shown_metrics(plan: Plan, comparison: Comparison) -> tuple[str, ...]:
    """Return the columns of a table: the plan's metrics, else all that any case has."""
    return tuple(dict.fromkeys(plan.metrics or (metric for row in comparison.rows for metric in row.estimates)))
