"""Two studies compared run by run: the effect of a change of the code."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from graphnav.core.stage import Better
from graphnav.studies.ablation.plan import Plan
from graphnav.studies.ablation.results.comparison import Difference, Estimate
from graphnav.studies.ablation.study import MetricExpression


def declaring_plan(plan_a: Plan, plan_b: Plan, column: str) -> Plan:
    """Return the plan that declares a column: the second one, unless only the first one does."""
    return plan_b if MetricExpression.parse(column).operands[0] in plan_b.declared else plan_a


@dataclass(frozen=True)
class PairedRow:
    """One case in both studies; everything but the seeds is of the worlds that both have."""

    graph: str
    variant: str
    seeds: tuple[int, ...]
    only_a: tuple[int, ...]
    """Seeds that only the first study has."""
    only_b: tuple[int, ...]
    outcomes_a: Mapping[str, int]
    outcomes_b: Mapping[str, int]
    estimates_a: Mapping[str, Estimate]
    """By metric, over the worlds in which both have it."""
    estimates_b: Mapping[str, Estimate]
    differences: Mapping[str, Difference]
    """The second minus the first; ``won``: in how many worlds the second was better."""
    own_frames: frozenset[str] = frozenset()
    """Metrics that are not compared: they depend on the frames met, and the plans do not show that these are alike."""


@dataclass(frozen=True)
class PairedStudies:
    """The runs that two studies have in common, and those that only one of them has."""

    plan_a: Plan
    plan_b: Plan
    metrics: Mapping[str, Better]
    rows: tuple[PairedRow, ...]
    only_a: tuple[tuple[str, str], ...]
    """Graph and variant of cases without a partner."""
    only_b: tuple[tuple[str, str], ...]

    def plan_of(self, column: str) -> Plan:
        """Return the plan that declares a column: that of the second study, unless only the first one does."""
        return declaring_plan(self.plan_a, self.plan_b, column)

    @property
    def primary(self) -> str | None:
        """The metric that decides: the first; None where there is none."""
        return next(iter(self.metrics), None)

    @property
    def graphs(self) -> tuple[str, ...]:
        """The graphs of the rows, in their order."""
        return tuple(dict.fromkeys(row.graph for row in self.rows))

    @property
    def different_versions(self) -> Mapping[str, tuple[str, str]]:
        """Versions that differ: by name, those of the first and second study; empty where unknown."""
        a, b = self.plan_a.versions, self.plan_b.versions
        return {
            name: (a.get(name, ""), b.get(name, ""))
            for name in dict.fromkeys([*a, *b])
            if a.get(name, "") != b.get(name, "")
        }
