"""Compare two studies in the worlds that both have."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from graphnav import UserError
from graphnav.core.stage import Better
from graphnav.studies.ablation.plan import Plan, shows_same_drive
from graphnav.studies.ablation.results.comparison import Difference, Estimate, as_family
from graphnav.studies.ablation.results.records import Record, in_plan_order
from graphnav.studies.ablation.results.study_values import (
    Values,
    difference,
    estimate,
    is_binary,
    table_metrics,
    values_of,
)
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


_Case = tuple[str, str]
"""Graph and variant."""
_Cases = Mapping[_Case, Mapping[int, Record]]
"""The records of a study, by case and seed."""
_Side = tuple[_Cases, Mapping[_Case, Mapping[str, Values]]]
"""The records of a study and the values of its columns, by case."""


def pair_studies(
    plan_a: Plan,
    records_a: Iterable[Record],
    plan_b: Plan,
    records_b: Iterable[Record],
    more: Iterable[MetricExpression] = (),
) -> PairedStudies:
    """Pair the runs of two studies by graph, variant and seed; ``more``: metrics besides those of their tables.

    Of cases that are the same graph in both studies, the first one is paired. Metrics that depend on the frames that a
    run meets are compared only where the plans show that the drive is unchanged (`shows_same_drive`).

    Raises
    ------
    UserError
        The studies have no run in common.
    """
    again = _shared(plan_a) & _shared(plan_b)
    all_a, all_b = (
        [record for record in in_plan_order(plan, records) if (record.graph, record.variant) not in again]
        for plan, records in ((plan_a, records_a), (plan_b, records_b))
    )
    cases_a, cases_b = _by_case(all_a), _by_case(all_b)
    matched = [case for case, runs in cases_a.items() if runs.keys() & cases_b.get(case, {}).keys()]
    if not matched:
        raise UserError.of(
            "the studies have no run in common: no graph, variant and seed is in both",
            "compare studies of the same graphs, variants and seeds",
        )
    columns = dict.fromkeys([*table_metrics(plan_a, all_a), *table_metrics(plan_b, all_b), *more])
    plans = {column: declaring_plan(plan_a, plan_b, column.text) for column in columns}
    values_a, values_b = (
        {case: {c.text: values_of(plan, c, runs.values()) for c in columns} for case, runs in cases.items()}
        for plan, cases in ((plan_a, cases_a), (plan_b, cases_b))
    )
    everything = [*values_a.values(), *values_b.values()]
    binary = {c.text for c, plan in plans.items() if is_binary(plan, c, (found[c.text] for found in everything))}
    by_name = {column.text: plan for column, plan in plans.items()}
    of_frames = frozenset(name for name, plan in by_name.items() if plan.is_of_frames(name))
    own_frames = {case: frozenset() if _is_same_drive(plan_a, plan_b, case) else of_frames for case in matched}
    rows = list(_rows(own_frames, (cases_a, values_a), (cases_b, values_b), by_name, binary))
    known = {name: plan for name, plan in by_name.items() if any(name in row.estimates_a for row in rows)}
    return PairedStudies(
        plan_a=plan_a,
        plan_b=plan_b,
        metrics={name: plan.better(name) for name, plan in known.items()},
        rows=tuple(_judged(rows, next(iter(known), None))),
        only_a=tuple(case for case in cases_a if case not in matched),
        only_b=tuple(case for case in cases_b if case not in matched),
    )


def _is_same_drive(plan_a: Plan, plan_b: Plan, case: _Case) -> bool:
    return shows_same_drive(plan_a, plan_a.case(*case), plan_b, plan_b.case(*case))


def _rows(
    matched: Mapping[_Case, frozenset[str]], a: _Side, b: _Side, plans: Mapping[str, Plan], binary: set[str]
) -> Iterator[PairedRow]:
    """Yield the row of each case; ``matched``: the metrics that are of frames of its own, by case."""
    spans = {text: plan.span(text) for text, plan in plans.items()}
    for case, own_frames in matched.items():
        (runs_a, of_a), (runs_b, of_b) = ((cases[case], values[case]) for cases, values in (a, b))
        seeds = tuple(seed for seed in runs_a if seed in runs_b)
        common = {text: (_also_in(of_b[text], of_a[text]), _also_in(of_a[text], of_b[text])) for text in plans}
        known = {text: pair for text, pair in common.items() if pair[0]}
        differences = {
            text: difference(
                new,
                old,
                plans[text].better(text),
                is_binary=text in binary,
                min_difference=plans[text].min_difference(text),
            )
            for text, (old, new) in known.items()
            if text not in own_frames
        }
        yield PairedRow(
            graph=case[0],
            variant=case[1],
            seeds=seeds,
            only_a=tuple(seed for seed in runs_a if seed not in runs_b),
            only_b=tuple(seed for seed in runs_b if seed not in runs_a),
            outcomes_a=Counter(runs_a[seed].outcome for seed in seeds),
            outcomes_b=Counter(runs_b[seed].outcome for seed in seeds),
            estimates_a={
                text: estimate(old, spans[text], is_binary=text in binary) for text, (old, _) in known.items()
            },
            estimates_b={
                text: estimate(new, spans[text], is_binary=text in binary) for text, (_, new) in known.items()
            },
            differences={text: found for text, found in differences.items() if found is not None},
            own_frames=own_frames.intersection(known),
        )


def _judged(rows: Sequence[PairedRow], primary: str | None) -> Iterator[PairedRow]:
    """Yield the rows with the significance of what decides: the variants of a graph are one family."""
    for row in rows:
        if primary is None or primary not in row.differences:
            yield row
            continue
        kin = [other for other in rows if other.graph == row.graph and primary in other.differences]
        family = as_family([other.differences[primary] for other in kin], len(kin))
        yield replace(row, differences={**row.differences, primary: family[kin.index(row)]})


def _shared(plan: Plan) -> set[_Case]:
    """Return the cases whose runs are those of another case."""
    return {(case.graph, case.variant) for case in plan.cases if case.same_as}


def _also_in(others: Values, values: Values) -> Values:
    """Return the values of the worlds that the others have, too."""
    return {seed: value for seed, value in values.items() if seed in others}


def _by_case(records: Iterable[Record]) -> _Cases:
    cases: dict[_Case, dict[int, Record]] = {}
    for record in records:
        cases.setdefault((record.graph, record.variant), {})[record.seed] = record
    return cases
