"""The table of a study: means with intervals, and paired differences from the base."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from graphnav.ablation.plan import Case

MIN_WORLDS = 6
"""Worlds from which on a difference may be called one."""


@dataclass(frozen=True)
class Estimate:
    """A mean over worlds with its 95 % interval; ``n`` worlds had the metric."""

    mean: float
    low: float
    high: float
    n: int


@dataclass(frozen=True)
class Difference:
    """The mean paired difference from the base (this minus base, same worlds) with its 95 % interval.

    ``won``, ``lost``: in how many of the ``n`` worlds that have both this was better and worse than the base; of a
    metric of which neither is better, higher and lower.
    """

    mean: float
    low: float
    high: float
    n: int
    won: int
    lost: int

    @property
    def is_clear(self) -> bool:
        """Whether the interval leaves out 0, over enough worlds to mean it.

        Where both are alike, n worlds all go one way with a chance of 2 / 2^n: 6 % for five, 3 % for six.
        """
        return self.n >= MIN_WORLDS and (self.low > 0 or self.high < 0)


@dataclass(frozen=True)
class Row:
    """One case of the table."""

    case: Case
    runs: int
    """The number of existing runs; fewer than the plan's seeds while a study is not finished."""
    outcomes: Mapping[str, int]
    failures: Mapping[str, int]
    """Reasons of failed runs and how many failed so."""
    estimates: Mapping[str, Estimate]
    """By metric; a metric that no run had is missing."""
    differences: Mapping[str, Difference]
    """By metric; empty for the base."""
    p50_ms: Mapping[str, float]
    """By stage: the median over runs of each run's median step."""
    own_frames: frozenset[str] = frozenset()
    """Metrics that are not compared with the base: they depend on the frames met, and this one drives differently."""


@dataclass(frozen=True)
class Comparison:
    """The table of a study: graph by graph, variants in the plan's order."""

    rows: tuple[Row, ...]

    def has_metric(self, metric: str) -> bool:
        """Return whether any run has a metric."""
        return any(metric in row.estimates for row in self.rows)

    def of_graph(self, graph: str) -> tuple[Row, ...]:
        """Return the rows of one graph."""
        return tuple(row for row in self.rows if row.case.graph == graph)
