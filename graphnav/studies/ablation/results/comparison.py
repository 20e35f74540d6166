"""The table of a study: means with intervals, and paired differences from the base."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from graphnav.studies.ablation.plan import Case
from graphnav.studies.ablation.results.statistics import Significance, bonett_price, holm

_ROUNDING = 1e-9


@dataclass(frozen=True)
class Estimate:
    """A mean over worlds with its 95 % interval; ``n`` worlds had the metric."""

    mean: float
    low: float
    high: float
    n: int
    is_approximate: bool = False
    """Whether the interval is short of 95 % where the metric is skewed: of few worlds, unless it is 0 or 1."""


@dataclass(frozen=True)
class Difference:
    """The mean paired difference of two variants (this minus the base, same worlds) with its 95 % interval.

    ``won``, ``lost``: in how many of the ``n`` worlds that have both this was better and worse than the base; of a
    metric of which neither is better, higher and lower.
    """

    mean: float
    low: float
    high: float
    n: int
    won: int
    lost: int
    p: float = math.nan
    """The chance of a mean difference as large, to either side, if the two are alike."""
    min_difference: float = 0.0
    """The smallest difference that matters."""
    significance: Significance | None = None
    """Of the metric that decides, in its family of comparisons; no other metric has one."""

    @property
    def tied(self) -> int:
        """In how many worlds neither was better."""
        return self.n - self.won - self.lost

    @property
    def is_clear(self) -> bool:
        """Whether it is significant in its family, matters, and its interval leaves out 0; only of what decides."""
        return self.is_significant and self.matters and (self.low > 0 or self.high < 0)

    @property
    def is_significant(self) -> bool:
        """Whether the metric decides and the difference is significant in its family."""
        return self.significance is not None and self.significance.is_significant

    @property
    def matters(self) -> bool:
        """Whether the mean is not smaller than the smallest difference that matters."""
        return matters(self.mean, self.min_difference)

    @property
    def probability_better(self) -> Estimate:
        """The chance to be better in a world, plus half that of a tie, with its interval.

        It is half of one more than the difference of the shares of worlds won and lost, and so is its interval, Bonett
        and Price's.
        """
        low, high = bonett_price(self.won, self.lost, self.n)
        mean = (self.won + self.tied / 2) / self.n
        return Estimate(mean, (1 + low) / 2, (1 + high) / 2, self.n)

    def reversed(self) -> Difference:
        """Return the difference of the other variant from this one."""
        return replace(self, mean=-self.mean, low=-self.high, high=-self.low, won=self.lost, lost=self.won)


def matters(mean: float, min_difference: float) -> bool:
    """Return whether a mean difference is not smaller than the smallest that matters."""
    return abs(mean) >= min_difference * (1 - _ROUNDING)


def as_family(differences: Sequence[Difference], family: int) -> list[Difference]:
    """Return differences with their significance among ``family`` comparisons, of which some may have no runs yet."""
    found = holm([difference.p for difference in differences], family)
    return [replace(difference, significance=of) for difference, of in zip(differences, found, strict=True)]


@dataclass(frozen=True)
class Row:
    """One case of the table."""

    case: Case
    runs: int
    """The number of existing runs."""
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
    pending: int = 0
    """The number of runs that are still to be made; of a study that its results stop, in its next round."""


@dataclass(frozen=True)
class Comparison:
    """The table of a study: graph by graph, variants in the plan's order."""

    rows: tuple[Row, ...]
    primary: str | None = None
    """The metric that decides: the first that any run has; None where there is none."""

    @property
    def runs(self) -> int:
        """The number of existing runs, shared ones counted once."""
        return sum(row.runs for row in self.rows if not row.case.same_as)

    @property
    def pending(self) -> int:
        """The number of runs that are still to be made; 0: the study is finished."""
        return sum(row.pending for row in self.rows if not row.case.same_as)

    def has_metric(self, metric: str) -> bool:
        """Return whether any run has a metric."""
        return any(metric in row.estimates for row in self.rows)

    def of_graph(self, graph: str) -> tuple[Row, ...]:
        """Return the rows of one graph."""
        return tuple(row for row in self.rows if row.case.graph == graph)
