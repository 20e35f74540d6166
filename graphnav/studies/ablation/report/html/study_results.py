"""The results of a study as the sections of its report read them: values, colours, verdicts."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Literal

from graphnav import Graph
from graphnav.core.catalog import Catalog
from graphnav.core.stage import Better
from graphnav.studies.ablation.plan import Case, Plan
from graphnav.studies.ablation.results import Comparison, Estimate, Record, Row, Values, table_metrics, values_of
from graphnav.studies.ablation.study import MetricExpression


@dataclass(frozen=True)
class StudyResults:
    """A study with its results."""

    plan: Plan
    comparison: Comparison
    records: Sequence[Record]
    folder: Path
    catalog: Catalog
    graphs: Mapping[str, Graph] = field(default_factory=dict)
    """Graphs that are loaded already, by `Case.folder`."""
    notes: Sequence[str] = ()
    """Sentences on the number of worlds."""
    drawn: frozenset[Path] = frozenset()
    """Maps with paths that are drawn already (`EarlyMaps`)."""

    @cached_property
    def metrics(self) -> tuple[str, ...]:
        """The columns of the tables that some run has, or all columns while no run is there."""
        every = [metric.text for metric in table_metrics(self.plan, self.records)]
        found = [name for name in every if self.comparison.has_metric(name)]
        return tuple(found or every)

    @property
    def deciding(self) -> str | None:
        """The metric that decides: the first that any run has; None where there is none at all."""
        return self.comparison.primary or (self.metrics[0] if self.metrics else None)

    @property
    def n_seeds(self) -> int:
        """The number of worlds."""
        return len(self.plan.seeds)

    def own_rows(self, graph: str) -> tuple[Row, ...]:
        """Return the rows of a graph that have runs of their own."""
        return tuple(row for row in self.comparison.of_graph(graph) if not row.case.same_as)

    @cached_property
    def own_variants(self) -> tuple[str, ...]:
        """Variants that have runs of their own on some graph, the base first."""
        return own_variants(self.plan)

    @cached_property
    def rows(self) -> Mapping[tuple[str, str], Row]:
        """All rows by graph and variant."""
        return {(row.case.graph, row.case.variant): row for row in self.comparison.rows}

    def estimate(self, graph: str, variant: str, metric: str) -> Estimate | None:
        """Return a mean, None where no run has the metric."""
        row = self.rows.get((graph, variant))
        return row.estimates.get(metric) if row else None

    def values(self, graph: str, variant: str, metric: str) -> Values:
        """Return a metric of every run of a case, by seed."""
        return values_of(self.plan, MetricExpression.parse(metric), self.runs.get((graph, variant), ()))

    @cached_property
    def runs(self) -> Mapping[tuple[str, str], Sequence[Record]]:
        """All records by graph and variant."""
        found: dict[tuple[str, str], list[Record]] = {}
        for record in self.records:
            found.setdefault((record.graph, record.variant), []).append(record)
        return found


BASE = "#1f5fa8"
METHODS = (
    "#d1495b", "#2a9d8f", "#e08e00", "#7b4fa3", "#4f9ddb", "#8c5a2b", "#d36ba6", "#6b8e23", "#00707f", "#b0413e",
)  # fmt: skip
BASELINES = ("#868e99", "#b1b7c0", "#5d6875")
ORACLES = ("#15191f", "#565d68")
OUTCOMES = ("goal", "end", "timeout", "contact", "failed", "stopped")
"""In the order in which bars show them; each has a class in the style sheet."""


def own_variants(plan: Plan) -> tuple[str, ...]:
    """Return the variants that have runs of their own on some graph, the base first."""
    return tuple(dict.fromkeys(case.variant for case in plan.cases if not case.same_as))


def colours_of(plan: Plan) -> dict[str, str]:
    """Return ``#rrggbb`` for every variant: the base blue, baselines gray, oracles black, methods in turn."""
    roles = {case.variant: case.role for case in plan.cases}
    found, used = {plan.base: BASE}, {"method": 0, "baseline": 0, "oracle": 0}
    palettes = {"method": METHODS, "baseline": BASELINES, "oracle": ORACLES}
    for variant in dict.fromkeys([*own_variants(plan), *plan.variants]):
        if variant not in found:
            role = roles[variant]
            found[variant] = palettes[role][used[role] % len(palettes[role])]
            used[role] += 1
    return found


def badge_of(case: Case) -> str:
    """Return the label beside a variant's name; empty for a method that is not the base."""
    return "base" if case.is_base else "" if case.role == "method" else case.role


Verdict = Literal["base", "better", "worse", "different", "small", "unclear", "unknown", "untested"]

WORDS: dict[Verdict, str] = {
    "base": "the base",
    "better": "better than the base",
    "worse": "worse than the base",
    "different": "different from the base",
    "small": "a difference smaller than what matters",
    "unclear": "no difference that these worlds can tell",
    "unknown": "too few worlds to say",
    "untested": "not tested",
}


def verdict_of(row: Row, metric: str, better: Better) -> Verdict:
    """Return the verdict of the paired difference: better or worse where it is clear, different where neither is.

    "untested" of a metric that does not decide, or that depends on the frames that a drive meets; "small" where the
    difference is significant and does not matter; "unknown" where it has no interval, or so few worlds that none of the
    table's variants could be told apart.
    """
    if row.case.is_base:
        return "base"
    if metric in row.own_frames:
        return "untested"
    difference = row.differences.get(metric)
    if difference is None or not (math.isfinite(difference.low) and math.isfinite(difference.high)):
        return "unknown"
    if difference.significance is None:
        return "untested"
    if difference.n < difference.significance.min_worlds:
        return "unknown"
    if not difference.is_clear:
        return "small" if difference.is_significant and not difference.matters else "unclear"
    if better == "neither":
        return "different"
    return "better" if (difference.mean > 0) == (better == "higher") else "worse"
