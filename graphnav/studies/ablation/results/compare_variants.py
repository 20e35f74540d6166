"""Compare the variants of a study with its base and with each other, in the same worlds."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from graphnav import Problem, UserError, did_you_mean
from graphnav.studies.ablation.plan import Case, Job, Plan
from graphnav.studies.ablation.results.comparison import Comparison, Difference, Estimate, Row, as_family
from graphnav.studies.ablation.results.records import Record
from graphnav.studies.ablation.results.study_values import StudyValues, key_of

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


def parse_pairs(texts: Sequence[str], variants: Sequence[str]) -> tuple[Pair, ...]:
    """Return the two variants of each ``A,B``; a variant's own name may contain commas.

    Raises
    ------
    UserError
        Everything that does not name two different variants of the study.
    """
    problems: list[Problem] = []
    pairs = []
    for text in texts:
        splits = [(a.strip(), b.strip()) for a, b in _splits(text)]
        found = [pair for pair in splits if pair[0] in variants and pair[1] in variants and pair[0] != pair[1]]
        if found:
            pairs.append(found[0])
        else:
            problems.append(_problem(text, splits, variants))
    if problems:
        raise UserError(problems)
    return tuple(pairs)


def _splits(text: str) -> Iterable[Pair]:
    """Yield the two parts of a string at each of its commas."""
    for place, char in enumerate(text):
        if char == ",":
            yield text[:place], text[place + 1 :]


def _problem(text: str, splits: Sequence[Pair], variants: Sequence[str]) -> Problem:
    known = f"variants of this study are {'; '.join(variants)}"
    if not splits:
        return Problem(None, f"contrast '{text}' names one variant", f"write two, A,B; {known}")
    first, second = splits[0]
    if first == second:
        return Problem(None, f"contrast '{text}' names the same variant twice", f"name two; {known}")
    unknown = first if first not in variants else second
    hint = did_you_mean(unknown, variants) or known
    return Problem(None, f"contrast '{text}': the study has no variant '{unknown}'", hint)


def compare(plan: Plan, records: Iterable[Record], pending: Iterable[Job] = ()) -> Comparison:
    """Return the table of a study: the plan's metrics, or all metrics where it names none.

    A world counts for a metric if its run has it, and for a difference if both runs have it: n is how many did. How
    failed runs count is described at `Record.counted`. A case that shares the base's runs has no differences, and a
    metric of the frames that a run meets has none where the two drive differently. All variants of a graph that may be
    compared with the base by the metric that decides, under one condition, are one family of comparisons. ``pending``:
    the runs that are still to be made.
    """
    study = StudyValues.of(plan, records)
    missing = Counter(job.case.folder for job in pending)
    primary = study.primary
    bases = {case.graph: case for case in plan.cases if case.is_base}
    rows = []
    for graph in plan.graphs:
        of_graph = [_row(study, case, bases[graph], missing) for case in plan.cases if case.graph == graph]
        rows += of_graph if primary is None else _judged(of_graph, primary, bases[graph])
    places = {key_of(case): place for place, case in enumerate(plan.cases)}
    return Comparison(tuple(sorted(rows, key=lambda row: places[key_of(row.case)])), primary)


def _judged(rows: Sequence[Row], primary: str, base: Case) -> list[Row]:
    """Return the rows of one graph with the significance of the differences by the metric that decides."""
    family = {row.case.folder for row in rows if primary not in row.own_frames} - {base.folder}
    known = {row.case.folder: row.differences[primary] for row in rows if primary in row.differences}
    judged = dict(zip(known, as_family(list(known.values()), len(family)), strict=True))
    return [
        replace(row, differences={**row.differences, primary: judged[row.case.folder]})
        if primary in row.differences
        else row
        for row in rows
    ]


def _row(study: StudyValues, case: Case, base: Case, missing: Mapping[str, int]) -> Row:
    key = key_of(case)
    runs = study.runs[key]
    own_frames = frozenset(name for name in study.metrics if not study.plan.are_comparable(case, base, name))
    estimates = {metric: study.estimate(key, metric) for metric in study.metrics}
    differences = {
        metric: study.difference(key, key_of(base), metric) for metric in study.metrics if case.folder != base.folder
    }
    times: dict[str, list[float]] = {}
    for run in runs:
        for stage, time in run.times.items():
            times.setdefault(stage, []).append(time.p50_ms)
    return Row(
        case=case,
        runs=len(runs),
        pending=missing.get(case.folder, 0),
        outcomes=Counter(run.outcome for run in runs),
        failures=Counter(run.cause for run in runs if run.cause),
        estimates={metric: found for metric, found in estimates.items() if found is not None},
        differences={metric: found for metric, found in differences.items() if found is not None},
        p50_ms={stage: float(np.median(found)) for stage, found in times.items()},
        own_frames=own_frames,
    )
