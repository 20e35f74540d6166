"""A study with its results, as the sections of the report look at it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from graphnav.core.catalog import Catalog
from graphnav.core.graph import Graph
from graphnav.studies.ablation.plan import Plan
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
        return tuple(dict.fromkeys(case.variant for case in self.plan.cases if not case.same_as))

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
