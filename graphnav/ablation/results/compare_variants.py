"""Means with intervals, and paired differences from the base."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from graphnav.ablation.report.csv_files import figure_columns
from graphnav.ablation.study.metric_expression import FigureText
from graphnav.ablation.plan.plan import Better, Case, Plan
from graphnav.ablation.results.records import Record, in_plan_order
from graphnav.ablation.results.intervals import difference_interval, mean_interval
from graphnav.stage.describe import unit_of

Values = Mapping[int, float]
"""One case's values of a figure, by seed: the seed is the world."""

LEAST_WORLDS = 6
"""Worlds from which on a difference may be called one."""

_MOMENT = re.compile(r" at \d+(\.\d+)? s\b")


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

    @property
    def is_clear(self) -> bool:
        """Whether the interval leaves out 0, over enough worlds to mean it.

        Where both are alike, n worlds all go one way with a chance of 2 / 2^n: 6 % for five, 3 % for six.
        """
        return self.n >= LEAST_WORLDS and (self.low > 0 or self.high < 0)


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

    def says(self, figure: str) -> bool:
        """Return whether any run has a figure."""
        return any(figure in row.estimates for row in self.rows)

    def of_graph(self, graph: str) -> tuple[Row, ...]:
        """Return the rows of one graph."""
        return tuple(row for row in self.rows if row.case.graph == graph)


def compare(plan: Plan, records: Iterable[Record]) -> Comparison:
    """Return the table of a study: the plan's figures, or every figure there is where it names none.

    A world counts for a figure if its run has it, and for a difference if both runs have it: n says how many did. How
    failed runs count is told at `Record.counted`. A case that shares the base's runs has no differences.
    """
    ordered = in_plan_order(plan, records)
    figures = table_figures(plan, ordered)
    by_case: dict[tuple[str, str], list[Record]] = {(case.graph, case.variant): [] for case in plan.cases}
    for record in ordered:
        by_case[record.graph, record.variant].append(record)
    values = {key: {figure.text: values_of(figure, runs) for figure in figures} for key, runs in by_case.items()}
    binary = {figure.text for figure in figures if is_binary(figure, (found[figure.text] for found in values.values()))}
    bases = {case.graph: case for case in plan.cases if case.is_base}
    return Comparison(
        tuple(
            _row(
                plan,
                case,
                by_case[case.graph, case.variant],
                values[case.graph, case.variant],
                None if case.folder == (base := bases[case.graph]).folder else values[base.graph, base.variant],
                binary,
            )
            for case in plan.cases
        )
    )


def table_figures(plan: Plan, records: Sequence[Record]) -> tuple[FigureText, ...]:
    """Return the columns of a study's table."""
    return tuple(map(FigureText.parse, plan.figures or figure_columns(plan, records)))


def values_of(figure: FigureText, runs: Iterable[Record]) -> Values:
    """Return a figure of every run that has it, by seed."""
    found = ((run.seed, figure.value(run.counted)) for run in runs)
    return {seed: value for seed, value in found if value is not None}


def is_binary(figure: FigureText, columns: Iterable[Values]) -> bool:
    """Return whether a figure is 0 or 1 wherever it is known and is meant to be.

    No difference and no ratio of figures is, and nothing with a unit: an error may be 0 px in every world.
    """
    return not (figure.operator or unit_of(figure.text)) and all(
        value in (0.0, 1.0) for column in columns for value in column.values()
    )


def estimate(values: Values, *, is_binary: bool) -> Estimate:
    """Return the mean of at least one world with its interval."""
    array = np.array(list(values.values()))
    return Estimate(float(array.mean()), *mean_interval(array, is_binary=is_binary), array.size)


def difference(values: Values, base: Values, better: Better, *, is_binary: bool) -> Difference | None:
    """Return how ``values`` differ from ``base`` in the worlds that both have; None where there is no such world."""
    seeds = [seed for seed in values if seed in base]
    if not seeds:
        return None
    this, that = (np.array([column[seed] for seed in seeds]) for column in (values, base))
    more, less = int(np.count_nonzero(this > that)), int(np.count_nonzero(this < that))
    won, lost = (more, less) if better == "more" else (less, more)
    interval = difference_interval(this, that, is_binary=is_binary)
    return Difference(float((this - that).mean()), *interval, len(seeds), won, lost)


def _row(
    plan: Plan,
    case: Case,
    runs: Sequence[Record],
    values: Mapping[str, Values],
    base: Mapping[str, Values] | None,
    binary: set[str],
) -> Row:
    differences = {
        figure: difference(column, base[figure], plan.better(figure), is_binary=figure in binary)
        for figure, column in values.items()
        if base is not None
    }
    times: dict[str, list[float]] = {}
    for run in runs:
        for stage, time in run.times.items():
            times.setdefault(stage, []).append(time.p50_ms)
    return Row(
        case=case,
        runs=len(runs),
        outcomes=Counter(run.outcome for run in runs),
        failures=Counter(_MOMENT.sub("", run.failure) for run in runs if run.failure),
        estimates={figure: estimate(column, is_binary=figure in binary) for figure, column in values.items() if column},
        differences={figure: found for figure, found in differences.items() if found is not None},
        p50_ms={stage: float(np.median(found)) for stage, found in times.items()},
    )
