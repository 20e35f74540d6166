"""The values of metrics by world, and what is compared of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from graphnav import GraphnavError
from graphnav.arrays import Doubles
from graphnav.core.stage import Better
from graphnav.studies.ablation.plan import Case, Plan
from graphnav.studies.ablation.results.comparison import Comparison, Difference, Estimate
from graphnav.studies.ablation.results.records import Record, in_plan_order
from graphnav.studies.ablation.results.statistics import (
    EXACT_BELOW,
    anytime_p,
    difference_interval,
    mean_interval,
    p_value,
)
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


CaseKey = tuple[str, str]
"""Graph and variant."""


@dataclass(frozen=True)
class StudyValues:
    """The columns of a study's table: the value of every world, for every case."""

    plan: Plan
    metrics: tuple[str, ...]
    runs: Mapping[CaseKey, Sequence[Record]]
    values: Mapping[CaseKey, Mapping[str, Values]]
    binary: frozenset[str]
    """Metrics that are 0 or 1 in every run."""

    @classmethod
    def of(cls, plan: Plan, records: Iterable[Record]) -> StudyValues:
        """Return the columns of the plan's metrics, or of all metrics where it names none."""
        ordered = in_plan_order(plan, records)
        metrics = table_metrics(plan, ordered)
        runs: dict[CaseKey, list[Record]] = {key_of(case): [] for case in plan.cases}
        for record in ordered:
            runs[record.graph, record.variant].append(record)
        values = {key: {metric.text: values_of(plan, metric, of) for metric in metrics} for key, of in runs.items()}
        binary = (m.text for m in metrics if is_binary(plan, m, (found[m.text] for found in values.values())))
        return cls(plan, tuple(metric.text for metric in metrics), runs, values, frozenset(binary))

    @property
    def primary(self) -> str | None:
        """The metric that decides: the first that any run has."""
        return next((name for name in self.metrics if any(found[name] for found in self.values.values())), None)

    def estimate(self, key: CaseKey, metric: str) -> Estimate | None:
        """Return the mean of a case, None where no run has the metric."""
        values = self.values[key][metric]
        return estimate(values, self.plan.span(metric), is_binary=metric in self.binary) if values else None

    def difference(self, key: CaseKey, base: CaseKey, metric: str) -> Difference | None:
        """Return how a case differs from another one in the worlds that both have.

        None if they share none, or met frames of their own that the metric depends on. In a study that its results
        stopped, the p-value of what decides is one that holds at any time.

        Raises
        ------
        GraphnavError
            A value of what decides such a study is outside of its bounds.
        """
        if not self.are_comparable(key, base, metric):
            return None
        values, others = self.values[key][metric], self.values[base][metric]
        found = difference(
            values,
            others,
            self.plan.better(metric),
            is_binary=metric in self.binary,
            min_difference=self.plan.min_difference(metric),
        )
        has_bounds = self.plan.metric(metric).limits is not None
        if found is None or not has_bounds or not self.plan.until_clear or metric != self.primary:
            return found
        shares = [scaled_values(self.plan, metric, *of, self.values[of][metric]) for of in (key, base)]
        return replace(found, p=anytime_p(paired_differences(*shares)))

    def are_comparable(self, key: CaseKey, base: CaseKey, metric: str) -> bool:
        """Return whether two cases may be compared by a metric."""
        return self.plan.are_comparable(self.plan.case(*key), self.plan.case(*base), metric)


def key_of(case: Case) -> CaseKey:
    """Return the graph and the variant of a case."""
    return case.graph, case.variant


def estimate(values: Values, span: tuple[float, float] | None, *, is_binary: bool) -> Estimate:
    """Return the mean of at least one world with its interval, which ends at the bounds of the metric if it has any."""
    array = np.array(list(values.values()))
    is_approximate = not is_binary and 1 < array.size < EXACT_BELOW
    low, high = np.clip(mean_interval(array, is_binary=is_binary), *(span or (-np.inf, np.inf)))
    return Estimate(float(array.mean()), float(low), float(high), array.size, is_approximate=is_approximate)


def difference(
    values: Values, base: Values, better: Better, *, is_binary: bool, min_difference: float = 0.0
) -> Difference | None:
    """Return how ``values`` differ from ``base`` in the worlds that both have; None if they share none."""
    seeds = [seed for seed in values if seed in base]
    if not seeds:
        return None
    this, that = (np.array([column[seed] for seed in seeds]) for column in (values, base))
    more, less = int(np.count_nonzero(this > that)), int(np.count_nonzero(this < that))
    won, lost = (less, more) if better == "lower" else (more, less)
    interval = difference_interval(this, that, is_binary=is_binary)
    p = p_value(this, that, is_binary=is_binary)
    return Difference(float((this - that).mean()), *interval, len(seeds), won, lost, p, min_difference)
