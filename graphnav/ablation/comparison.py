"""Means with intervals, and paired differences from the base."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from graphnav.ablation.plan import Case


@dataclass(frozen=True)
class Estimate:
    """A mean over worlds with its 95 % interval; ``n`` worlds had the figure."""

    mean: float
    low: float
    high: float
    n: int


@dataclass(frozen=True)
class Difference:
    """The mean paired difference from the base (this minus base, same worlds) with its 95 % interval.

    ``won``, ``lost``: in how many of the ``n`` worlds that have both this was better and worse than the base.
    """

    mean: float
    low: float
    high: float
    n: int
    won: int
    lost: int


@dataclass(frozen=True)
class Row:
    """One case of the table."""

    case: Case
    runs: int
    """How many runs are there; fewer than the plan's seeds while a study is not finished."""
    outcomes: Mapping[str, int]
    failures: Mapping[str, int]
    """Reasons of failed runs and how many failed so."""
    estimates: Mapping[str, Estimate]
    """By figure; a figure that no run had is missing."""
    differences: Mapping[str, Difference]
    """By figure; empty for the base."""
    p50_ms: Mapping[str, float]
    """By stage: the median over runs of each run's median step."""


@dataclass(frozen=True)
class Comparison:
    """The table of a study: graph by graph, variants in the plan's order."""

    rows: tuple[Row, ...]

    def of_graph(self, graph: str) -> tuple[Row, ...]:
        """Return the rows of one graph."""
        return tuple(row for row in self.rows if row.case.graph == graph)
