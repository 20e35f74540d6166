"""Two studies side by side, run by run: what a change of the code did."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from graphnav.ablation.comparison import (
    Difference,
    Estimate,
    Values,
    difference,
    estimate,
    is_binary,
    table_figures,
    values_of,
)
from graphnav.ablation.figure_text import FigureText
from graphnav.ablation.plan import Better, Plan
from graphnav.ablation.records import Record, in_plan_order
from graphnav.errors import UserError

_Case = tuple[str, str]
"""Graph and variant."""
_Cases = Mapping[_Case, Mapping[int, Record]]
"""The records of a study, by case and seed."""


@dataclass(frozen=True)
class PairRow:
    """One graph with one variant, in both studies; everything but the seeds is of the worlds that both have."""

    graph: str
    variant_a: str
    variant_b: str
    seeds: tuple[int, ...]
    only_a: tuple[int, ...]
    """Seeds that only the first study has."""
    only_b: tuple[int, ...]
    outcomes_a: Mapping[str, int]
    outcomes_b: Mapping[str, int]
    estimates_a: Mapping[str, Estimate]
    """By figure, over the worlds in which both have it."""
    estimates_b: Mapping[str, Estimate]
    differences: Mapping[str, Difference]
    """The second minus the first; ``won``: in how many worlds the second was better."""

    @property
    def name(self) -> str:
        """The variant, or both where two different ones are paired."""
        return self.variant_a if self.variant_a == self.variant_b else f"{self.variant_a} : {self.variant_b}"


@dataclass(frozen=True)
class Pairing:
    """What two studies have in common, and what only one of them has."""

    plan_a: Plan
    plan_b: Plan
    figures: Mapping[str, Better]
    rows: tuple[PairRow, ...]
    only_a: tuple[tuple[str, str], ...]
    """Graph and variant of cases without a partner."""
    only_b: tuple[tuple[str, str], ...]

    @property
    def graphs(self) -> tuple[str, ...]:
        """The graphs of the rows, in their order."""
        return tuple(dict.fromkeys(row.graph for row in self.rows))

    @property
    def different_versions(self) -> Mapping[str, tuple[str, str]]:
        """What the studies ran with where it differs: name, of the first, of the second; empty where unknown."""
        a, b = self.plan_a.versions, self.plan_b.versions
        return {
            name: (a.get(name, ""), b.get(name, ""))
            for name in dict.fromkeys([*a, *b])
            if a.get(name, "") != b.get(name, "")
        }


def pair_studies(
    plan_a: Plan,
    records_a: Iterable[Record],
    plan_b: Plan,
    records_b: Iterable[Record],
    variants: Sequence[tuple[str, str]] = (),
) -> Pairing:
    """Pair the runs of two studies by graph, variant and seed.

    ``variants``: pairs of a variant of the first and one of the second study that are compared instead of those of the
    same name. Cases that are the same graph as another one in both studies are told once.

    Raises
    ------
    UserError
        There is no such variant, or the studies have no run in common.
    """
    again = set() if variants else _shared(plan_a) & _shared(plan_b)
    all_a, all_b = (
        [record for record in in_plan_order(plan, records) if (record.graph, record.variant) not in again]
        for plan, records in ((plan_a, records_a), (plan_b, records_b))
    )
    cases_a, cases_b = _by_case(all_a), _by_case(all_b)
    pairs = list(variants) or [(variant, variant) for variant in plan_a.variants]
    for side, plan, names in (
        ("first", plan_a, [a for a, _ in variants]),
        ("second", plan_b, [b for _, b in variants]),
    ):
        for name in names:
            if name not in plan.variants:
                raise UserError.of(f"the {side} study has no variant '{name}'", f"it has {', '.join(plan.variants)}")
    columns = dict.fromkeys([*table_figures(plan_a, all_a), *table_figures(plan_b, all_b)])
    figures = {
        figure.text: (plan_b if figure.text in plan_b.figures else plan_a).better(figure.text) for figure in columns
    }
    matched = [
        ((graph, a), (graph, b))
        for graph in plan_a.graphs
        for a, b in pairs
        if cases_a.get((graph, a), {}).keys() & cases_b.get((graph, b), {}).keys()
    ]
    if not matched:
        raise UserError.of(
            "the studies have no run in common: no graph, variant and seed is in both",
            "compare studies of the same graphs and seeds; pair variants of different names explicitly",
        )
    rows = tuple(_rows(matched, cases_a, cases_b, tuple(columns), figures))
    return Pairing(
        plan_a=plan_a,
        plan_b=plan_b,
        figures={name: better for name, better in figures.items() if any(name in row.differences for row in rows)},
        rows=rows,
        only_a=_alone(cases_a, [a for a, _ in matched], [a for a, _ in variants]),
        only_b=_alone(cases_b, [b for _, b in matched], [b for _, b in variants]),
    )


def _rows(
    matched: Sequence[tuple[_Case, _Case]],
    cases_a: _Cases,
    cases_b: _Cases,
    columns: Sequence[FigureText],
    figures: Mapping[str, Better],
) -> Iterator[PairRow]:
    values_a = {case: {c.text: values_of(c, runs.values()) for c in columns} for case, runs in cases_a.items()}
    values_b = {case: {c.text: values_of(c, runs.values()) for c in columns} for case, runs in cases_b.items()}
    everything = [*values_a.values(), *values_b.values()]
    binary = {column.text for column in columns if is_binary(column, (found[column.text] for found in everything))}
    for a, b in matched:
        runs_a, runs_b = cases_a[a], cases_b[b]
        seeds = tuple(seed for seed in runs_a if seed in runs_b)
        common = {
            text: (_of(values_a[a][text], values_b[b][text]), _of(values_b[b][text], values_a[a][text]))
            for text in figures
        }
        known = {text: pair for text, pair in common.items() if pair[0]}
        differences = {
            text: difference(of_b, of_a, figures[text], is_binary=text in binary)
            for text, (of_a, of_b) in known.items()
        }
        yield PairRow(
            graph=a[0],
            variant_a=a[1],
            variant_b=b[1],
            seeds=seeds,
            only_a=tuple(seed for seed in runs_a if seed not in runs_b),
            only_b=tuple(seed for seed in runs_b if seed not in runs_a),
            outcomes_a=Counter(runs_a[seed].outcome for seed in seeds),
            outcomes_b=Counter(runs_b[seed].outcome for seed in seeds),
            estimates_a={text: estimate(of_a, is_binary=text in binary) for text, (of_a, _) in known.items()},
            estimates_b={text: estimate(of_b, is_binary=text in binary) for text, (_, of_b) in known.items()},
            differences={text: found for text, found in differences.items() if found is not None},
        )


def _shared(plan: Plan) -> set[_Case]:
    """Return the cases whose runs are those of another case."""
    return {(case.graph, case.variant) for case in plan.cases if case.same_as}


def _alone(cases: Iterable[_Case], matched: Sequence[_Case], asked: Sequence[str]) -> tuple[_Case, ...]:
    """Return the cases without a partner; of the variants asked for, where some are."""
    return tuple(case for case in cases if case not in matched and (not asked or case[1] in asked))


def _of(values: Values, others: Values) -> Values:
    """Return the values of the worlds that both have."""
    return {seed: value for seed, value in values.items() if seed in others}


def _by_case(records: Iterable[Record]) -> _Cases:
    cases: dict[_Case, dict[int, Record]] = {}
    for record in records:
        cases.setdefault((record.graph, record.variant), {})[record.seed] = record
    return cases
