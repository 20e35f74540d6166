"""Metrics of a drive with its stages replaced by their oracles."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from graphnav.core.stage import Better
from graphnav.studies.ablation.plan import Case, Plan
from graphnav.studies.ablation.results.comparison import Difference, Estimate
from graphnav.studies.ablation.results.records import Record, are_cut_off
from graphnav.studies.ablation.results.study_values import Values, difference, estimate, is_binary, values_of
from graphnav.studies.ablation.study import MetricExpression
from graphnav.studies.ablation.study.study import BASE, COMMON, CONDITION


@dataclass(frozen=True)
class Swap:
    """A stage that was swapped for its oracle, alone or after those before it."""

    stage: str
    estimate: Estimate | None
    """With the stage swapped; None where no run has the metric."""
    gain: Difference | None
    """From the graph as it is, or from the step before, in the same worlds; None where they share none, or where the
    metric depends on the frames and each met its own."""
    is_same: bool
    """Whether it is the same graph as the one that it is compared with."""
    unused: tuple[str, ...]
    """Of the stages that are oracles in this variant, those that do not drive: nothing that drives reads them."""


@dataclass(frozen=True)
class Losses:
    """Losses of the stages of one graph by one metric."""

    graph: str
    metric: str
    is_common: bool
    """Whether all variants met the same frames, those of an oracle's drive."""
    as_it_is: Estimate
    single: tuple[Swap, ...]
    """One stage at a time, each compared with the graph as it is."""
    cumulative: tuple[Swap, ...]
    """One more stage each, compared with the step before."""
    better: Better = "higher"
    span: tuple[float, float] | None = None
    """The bounds of the metric, if it has any."""
    is_cut_off: bool = False
    """Whether the time limit ended every run before it arrived, so that the metric tells nothing of the stages."""


def losses(plan: Plan, records: Iterable[Record]) -> tuple[Losses, ...]:
    """Return what a decomposed study lost where, graph by graph; nothing for other studies.

    A metric of the frames that a run meets is taken on the oracle's drive, all others on each variant's own.
    """
    runs: dict[tuple[str, str], list[Record]] = {}
    for record in records:
        runs.setdefault((record.graph, record.variant), []).append(record)
    return tuple(_losses(plan, runs)) if plan.decomposition is not None else ()


def _losses(plan: Plan, runs: dict[tuple[str, str], list[Record]]) -> Iterator[Losses]:
    assert plan.decomposition is not None
    for source in plan.sources:
        of_source = [
            run for case in plan.cases if case.source == source for run in runs.get((case.graph, case.variant), ())
        ]
        is_cut_off = are_cut_off(plan, of_source)
        for metric in map(MetricExpression.parse, plan.metrics):
            is_common = plan.decomposition.has_common_drive and plan.is_of_frames(metric.text)
            cases = {
                case.variant: case
                for case in plan.cases
                if case.source == source and (case.labels.get(CONDITION) == COMMON) == is_common
            }
            values = {name: values_of(plan, metric, runs.get((of.graph, name), ())) for name, of in cases.items()}
            found = _Compared(plan, metric, cases, values)
            as_it_is = found.estimate(BASE)
            if as_it_is is None:
                continue
            single, steps = plan.decomposition.single, plan.decomposition.cumulative
            yield Losses(
                source,
                metric.text,
                is_common,
                as_it_is,
                tuple(found.swap(stage, stage, BASE) for stage in single),
                tuple(found.swap(*of) for of in zip(single, steps, (BASE, *steps), strict=False)),
                plan.better(metric.text),
                plan.span(metric.text),
                is_cut_off and not plan.is_of_frames(metric.text),
            )


@dataclass(frozen=True)
class _Compared:
    """The variants of a graph by one metric."""

    plan: Plan
    metric: MetricExpression
    cases: dict[str, Case]
    values: dict[str, Values]

    @property
    def is_binary(self) -> bool:
        return is_binary(self.plan, self.metric, self.values.values())

    def estimate(self, variant: str) -> Estimate | None:
        values = self.values[variant]
        span = self.plan.span(self.metric.text)
        return estimate(values, span, is_binary=self.is_binary) if values else None

    def swap(self, stage: str, variant: str, before: str) -> Swap:
        assert self.plan.decomposition is not None
        is_same = self.cases[variant].folder == self.cases[before].folder
        driving = self.cases[variant].driving
        unused = [name for name in self.plan.decomposition.stages_of(variant) if name not in driving]
        return Swap(
            stage, self.estimate(variant), None if is_same else self.gain(variant, before), is_same, tuple(unused)
        )

    def gain(self, variant: str, before: str) -> Difference | None:
        if not self.plan.are_comparable(self.cases[variant], self.cases[before], self.metric.text):
            return None
        better = self.plan.better(self.metric.text)
        return difference(self.values[variant], self.values[before], better, is_binary=self.is_binary)
