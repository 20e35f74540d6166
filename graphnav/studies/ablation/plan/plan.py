"""A checked study: every graph with every variant, and its runs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from graphnav import Metric, Role
from graphnav.core.graph import Override
from graphnav.core.stage import Better, unit_of
from graphnav.studies.ablation.study import Decomposition, MetricExpression

RUNS = "runs"
"""Where runs are, below the study's folder."""


@dataclass(frozen=True)
class Case:
    """One graph with one variant, checked."""

    graph: str
    """As tables call it: the graph's name and, where variants are compared within conditions, the condition."""
    source: str
    """The graph as the study names it."""
    variant: str
    """Its name in tables; the same over all graphs."""
    labels: Mapping[str, str]
    """Its choice of every axis."""
    overrides: tuple[Override, ...]
    is_base: bool
    role: Role
    """As `variant_roles` finds it: "oracle", "baseline" or "method"."""
    folder: str
    """Where its runs are, below the study's folder; unique unless another case resolves to the same graph."""
    same_as: str
    """The variant whose runs these are, because both resolve to the same graph; empty for runs of its own."""
    uses: Mapping[str, str]
    """The ``use`` of every stage, in the graph's order."""
    swapped: tuple[str, ...]
    """Stages that are not what they are in the base."""
    notices: tuple[str, ...]
    """Notices of what was rewired, pruned and set to defaults."""
    graph_yaml: str
    """The resolved graph, portable."""
    driving: tuple[str, ...] = ()
    """The stages that drive the world's robot, in firing order."""
    drives_as: str = ""
    """The first variant whose drive is this one: in the same world both meet the same frames."""


@dataclass(frozen=True)
class Job:
    """A pending run."""

    case: Case
    seed: int

    @property
    def folder(self) -> str:
        """Return where it is made, below the study's folder."""
        return f"{self.case.folder}/{self.seed}"


@dataclass(frozen=True)
class Plan:
    """A checked study; ``plan.json`` in its folder, from which every report can be made again."""

    name: str
    about: str
    command: str
    """The exact command that runs it again."""
    graphs: tuple[str, ...]
    """As tables call them, each with a base of its own."""
    axes: Mapping[str, tuple[str, ...]]
    """The labels of each axis, the base's first."""
    seeds: tuple[int, ...]
    metrics: tuple[str, ...]
    """Columns of the table, ``stage.metric`` or two of them, the one that decides first; empty for all metrics."""
    cases: tuple[Case, ...]
    """Graph by graph, in the same order of variants; the base first."""
    reference: str = ""
    """The variant whose runs metrics may be relative to; empty for none."""
    until_clear: bool = False
    """Whether worlds are added until the metric that decides tells each variant from the base."""
    worlds: Mapping[str, int] = field(default_factory=dict)
    """By graph, as the study names it: how many of the seeds are its worlds; all where it is not named."""
    within: tuple[str, ...] = ()
    """Axes that are conditions, within which variants are compared."""
    declared: Mapping[str, Metric] = field(default_factory=dict)
    """Metrics that the stages of the cases declare, by ``stage.metric``."""
    plugins: tuple[str, ...] = ()
    """Files given with ``--plugin`` and those that the graphs name, absolute."""
    versions: Mapping[str, str] = field(default_factory=dict)
    decomposition: Decomposition | None = None
    """Its stages and their oracles; None where it decomposes nothing."""

    @cached_property
    def variants(self) -> tuple[str, ...]:
        """All variants, the base first."""
        return tuple(dict.fromkeys(case.variant for case in self.cases))

    @property
    def sources(self) -> tuple[str, ...]:
        """The graphs as the study names them."""
        return tuple(dict.fromkeys(case.source for case in self.cases))

    @property
    def base(self) -> str:
        """The variant that all others are compared with."""
        return next(case.variant for case in self.cases if case.is_base)

    @property
    def jobs(self) -> Iterator[Job]:
        """Every run of the study, seed by seed, so that all variants grow together."""
        for place, seed in enumerate(self.seeds):
            for case in self.cases:
                if not case.same_as and place < self.n_worlds(case):
                    yield Job(case, seed)

    @property
    def n_jobs(self) -> int:
        """The number of runs."""
        return sum(self.n_worlds(case) for case in self.cases if not case.same_as)

    def n_worlds(self, case: Case) -> int:
        """Return the number of worlds of a case."""
        return min(self.worlds.get(case.source, len(self.seeds)), len(self.seeds))

    def seeds_of(self, case: Case) -> tuple[int, ...]:
        """Return the worlds of a case: the first of the seeds."""
        return self.seeds[: self.n_worlds(case)]

    def metric(self, name: str) -> Metric:
        """Return what is declared of ``stage.metric``."""
        return self.declared.get(name) or _undeclared(name)

    def better(self, column: str) -> Better:
        """Return which values of a column are better; a difference or a ratio is better where its first metric is."""
        return self.metric(MetricExpression.parse(column).operands[0]).better

    def min_difference(self, column: str) -> float:
        """Return the smallest difference of a column that matters: of its metric, or of the first of a difference.

        Any difference of a ratio matters: what is declared is in the unit of the metric.
        """
        read = MetricExpression.parse(column)
        return 0.0 if read.operator == "/" else self.metric(read.operands[0]).min_difference

    def span(self, column: str) -> tuple[float, float] | None:
        """Return the lowest and the highest possible value of a column; None: unknown, as of a difference.

        A ratio of metrics that cannot be negative cannot be, either.
        """
        read = MetricExpression.parse(column)
        spans = [self.metric(name).span for name in read.operands]
        if not read.operator:
            return spans[0]
        is_positive = read.operator == "/" and all(span is not None and span[0] >= 0 for span in spans)
        return (0.0, math.inf) if is_positive else None

    def are_comparable(self, one: Case, other: Case, column: str) -> bool:
        """Return whether two cases of a graph may be compared by a column.

        What depends on the frames that a run meets (`Metric.of_frames`) is compared only where both drive alike.
        """
        return one.drives_as == other.drives_as or not self.is_of_frames(column)

    def is_of_frames(self, column: str) -> bool:
        """Return whether a column depends on the frames that a run meets."""
        return any(self.metric(name).of_frames for name in MetricExpression.parse(column).operands)

    def label(self, column: str) -> str:
        """Return the heading of a column: its metric, with the unit where the name does not tell it."""
        read = MetricExpression.parse(column)
        if read.operator:
            return column
        return f"{column.partition('.')[0]}.{self.metric(column).label}"

    def case(self, graph: str, variant: str) -> Case:
        """Return the case of a graph and a variant."""
        return next(case for case in self.cases if (case.graph, case.variant) == (graph, variant))


def _undeclared(name: str) -> Metric:
    """Return what is known of a metric that runs of version 0.1.0 report and its plan does not name."""
    metric = name.partition(".")[2]
    return Metric(metric, help="", unit=unit_of(metric).symbol, better="higher")
