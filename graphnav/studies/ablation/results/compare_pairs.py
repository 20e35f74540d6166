"""Compare any two variants of a study, and all pairs of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

from graphnav.studies.ablation.plan import Plan
from graphnav.studies.ablation.results.comparison import Difference, Estimate, as_family
from graphnav.studies.ablation.results.records import Record
from graphnav.studies.ablation.results.study_values import StudyValues

Pair = tuple[str, str]
"""Two variants."""


@dataclass(frozen=True)
class Contrast:
    """Two variants on one graph, by every metric that both have."""

    graph: str
    first: str
    second: str
    estimates: Mapping[str, tuple[Estimate, Estimate]]
    """By metric: those of the first and of the second, over all their worlds."""
    differences: Mapping[str, Difference]
    """By metric: the first minus the second; ``won``: in how many worlds the first was better."""


@dataclass(frozen=True)
class AllPairs:
    """All pairs of the variants of one graph, by the metric that decides: one family of comparisons."""

    graph: str
    variants: tuple[str, ...]
    """Those with runs of their own, the base first."""
    differences: Mapping[Pair, Difference]
    """Of both orders of each pair: the first minus the second; pairs without a common world are missing."""
    own_frames: frozenset[Pair] = frozenset()
    """Pairs that are missing because the metric depends on the frames met, and each met its own."""


def contrasts(plan: Plan, records: Iterable[Record], pairs: Sequence[Pair]) -> tuple[Contrast, ...]:
    """Return pairs of variants, graph by graph; the pairs of a graph are one family by the metric that decides."""
    study = StudyValues.of(plan, records)
    found = []
    for graph in plan.graphs:
        here = [pair for pair in dict.fromkeys(pairs) if all((graph, variant) in study.values for variant in pair)]
        judged = _differences(study, graph, here, study.primary)
        found += [_contrast(study, graph, pair, judged.get(pair)) for pair in here]
    return tuple(found)


def all_pairs(plan: Plan, records: Iterable[Record]) -> tuple[AllPairs, ...]:
    """Return the pairs of all variants that have runs of their own, graph by graph."""
    study = StudyValues.of(plan, records)
    found = []
    for graph in plan.graphs:
        own = tuple(case.variant for case in plan.cases if case.graph == graph and not case.same_as)
        pairs = list(combinations(own, 2))
        judged = _differences(study, graph, pairs, study.primary)
        both = {**judged, **{(b, a): difference.reversed() for (a, b), difference in judged.items()}}
        found.append(AllPairs(graph, own, both, frozenset(_of_own_frames(study, graph, pairs))))
    return tuple(found)


def _of_own_frames(study: StudyValues, graph: str, pairs: Iterable[Pair]) -> Iterator[Pair]:
    for a, b in pairs:
        if study.primary is not None and not study.are_comparable((graph, a), (graph, b), study.primary):
            yield from ((a, b), (b, a))


def _differences(study: StudyValues, graph: str, pairs: Sequence[Pair], metric: str | None) -> dict[Pair, Difference]:
    """Return the differences of pairs by one metric, with their significance in the family of all of them."""
    if metric is None:
        return {}
    keys = {pair: ((graph, pair[0]), (graph, pair[1])) for pair in pairs}
    known = {pair: study.difference(*both, metric) for pair, both in keys.items()}
    found = {pair: difference for pair, difference in known.items() if difference is not None}
    family = sum(study.are_comparable(*both, metric) for both in keys.values())
    return dict(zip(found, as_family(list(found.values()), family), strict=True))


def _contrast(study: StudyValues, graph: str, pair: Pair, judged: Difference | None) -> Contrast:
    first, second = ((graph, variant) for variant in pair)
    means = {metric: (study.estimate(first, metric), study.estimate(second, metric)) for metric in study.metrics}
    differences = {metric: study.difference(first, second, metric) for metric in study.metrics}
    if judged is not None and study.primary is not None:
        differences[study.primary] = judged
    return Contrast(
        graph,
        *pair,
        {metric: (one, other) for metric, (one, other) in means.items() if one is not None and other is not None},
        {metric: found for metric, found in differences.items() if found is not None},
    )
