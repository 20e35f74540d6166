"""The metrics of all runs of a study, by case and world."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from graphnav.core.stage import Better
from graphnav.studies.ablation.plan import Case, Plan
from graphnav.studies.ablation.results.comparison import Difference, Estimate
from graphnav.studies.ablation.results.metric_values import (
    Values,
    is_binary,
    paired_differences,
    scaled_values,
    table_metrics,
    values_of,
)
from graphnav.studies.ablation.results.records import Record, in_plan_order
from graphnav.studies.ablation.results.statistics import (
    EXACT_BELOW,
    anytime_p,
    difference_interval,
    mean_interval,
    p_value,
)

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
