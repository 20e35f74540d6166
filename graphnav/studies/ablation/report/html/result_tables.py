"""Tables of results: variants, all pairs, times per step, what each oracle adds."""

from __future__ import annotations

import base64
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from graphnav.core.stage import Better
from graphnav.core.tables import Column, Table
from graphnav.studies.ablation.report.decomposition import (
    decomposition_picture,
    loss_table,
    notes,
    sentences,
)
from graphnav.studies.ablation.report.html.charts import stacked_bars
from graphnav.studies.ablation.report.html.forest_plot import MAX_ROWS, NO_COMMON_WORLD, shown_variants
from graphnav.studies.ablation.report.html.rendering import counted, estimate_text, estimated, rendered
from graphnav.studies.ablation.report.html.study_results import (
    BASE,
    METHODS,
    OUTCOMES,
    StudyResults,
    Verdict,
    badge_of,
    verdict_of,
)
from graphnav.studies.ablation.report.legend import OWN_FRAMES, worlds_text
from graphnav.studies.ablation.report.number_format import TOO_SMALL, p_text
from graphnav.studies.ablation.results import AllPairs, Difference, Pair, Row, all_pairs, losses, min_worlds

_MAX_OPEN = 40
"""Longer tables are folded."""


@dataclass(frozen=True)
class _Cell:
    """A mean and its paired difference; no ``value``: no run has the metric; ``n``: in how many, where not in all."""

    value: str = ""
    interval: str = ""
    n: int | None = None
    change: str = ""
    verdict: Verdict | None = None
    details: Sequence[str] = ()
    """In how many worlds it was better, the chance to be, and the p-values of what decides."""


@dataclass(frozen=True)
class _TableRow:
    """A variant on a graph; with ``same_as`` the row says only that."""

    variant: str
    badge: str
    same_as: str
    look: str
    failures: Sequence[str]
    worlds: str
    outcomes: Sequence[tuple[str, int]]
    metrics: Sequence[_Cell]


def tables(study: StudyResults) -> Markup:
    """Return a table for every graph."""
    graphs = study.plan.graphs
    return rendered(
        "result_tables.html",
        metrics=[(study.plan.label(name), study.plan.better(name)) for name in study.metrics],
        tables=[(graph, [_row(study, row) for row in study.comparison.of_graph(graph)]) for graph in graphs],
        max_open=_MAX_OPEN,
    )


def _row(study: StudyResults, row: Row) -> _TableRow:
    case = row.case
    return _TableRow(
        case.variant,
        badge_of(case),
        case.same_as,
        f"{case.role} base" if case.is_base else case.role,
        [f"{counted(n, 'run')} failed: {reason}" for reason, n in row.failures.items()],
        worlds_text(row),
        [(name, row.outcomes[name]) for name in OUTCOMES if row.outcomes.get(name)],
        [_cell(study, row, metric) for metric in study.metrics],
    )


def _cell(study: StudyResults, row: Row, metric: str) -> _Cell:
    estimate, difference = row.estimates.get(metric), row.differences.get(metric)
    if estimate is None:
        return _Cell()
    value, _, interval = estimate_text(estimate).partition(" ")
    n = None if estimate.n >= row.runs else estimate.n
    if difference is None:
        return _Cell(value, interval, n, OWN_FRAMES if metric in row.own_frames else "")
    change = estimated(difference.mean, difference.low, difference.high, signed=True)
    better = study.plan.better(metric)
    return _Cell(value, interval, n, change, verdict_of(row, metric, better), list(_details(difference, better)))


def _details(found: Difference, better: Better) -> Iterator[str]:
    names = ("higher", "alike", "lower") if better == "neither" else ("won", "tied", "lost")
    worlds = zip(names, (found.won, found.tied, found.lost), strict=True)
    yield ", ".join(f"{name} {n}" for name, n in worlds) + f" of {found.n}"
    chance = found.probability_better
    yield f"{'higher' if better == 'neither' else 'better'} with {estimated(chance.mean, chance.low, chance.high)}"
    if found.significance is not None:
        small = f", {TOO_SMALL}" if found.is_significant and not found.matters else ""
        yield f"{p_text(found.p)}, in its family {p_text(found.significance.p_holm)}{small}"


_MIN_VARIANTS = 3
"""The pairs of fewer variants are in the tables of differences from the base."""
_MAX_VARIANTS = 60
"""Of more, the pairs are not compared: there are thousands, and no worlds that could tell them apart."""
_MAX_WIDE = 8
"""Variants of a matrix that is not folded."""


@dataclass(frozen=True)
class _PairCell:
    """A pair: above the diagonal its difference, below it how the worlds went."""

    lines: Sequence[str] = ()
    verdict: str = ""


@dataclass(frozen=True)
class _Matrix:
    """The pairs of one graph; rows in the order of the columns."""

    graph: str
    variants: Sequence[str]
    rows: Sequence[tuple[str, Sequence[_PairCell]]]
    n_pairs: int
    too_few: str
    """How many worlds it takes to tell any pair apart, where there are fewer."""
    n_left_out: int
    is_open: bool


def pair_matrices(study: StudyResults) -> Markup:
    """Return a matrix for each graph with three variants or more, of many variants of those that plots show."""
    metric = study.deciding
    if metric is None or not study.comparison.runs or len(study.own_variants) > _MAX_VARIANTS:
        return Markup("")
    shown = shown_variants(study, metric)
    better = study.plan.better(metric)
    every = [pairs for pairs in all_pairs(study.plan, study.records) if len(pairs.variants) >= _MIN_VARIANTS]
    matrices = [_matrix(pairs, shown, better) for pairs in every]
    return rendered("pair_matrix.html", metric=metric, matrices=matrices)


def _matrix(pairs: AllPairs, shown: Sequence[str], better: Better) -> _Matrix:
    variants = [variant for variant in pairs.variants if variant in shown]
    rows = [
        (row, [_pair_cell(pairs, (row, column), better, is_upper=x > y) for x, column in enumerate(variants)])
        for y, row in enumerate(variants)
    ]
    n_pairs = len(pairs.variants) * (len(pairs.variants) - 1) // 2
    n, needed = max((found.n for found in pairs.differences.values()), default=0), min_worlds(n_pairs)
    too_few = f"{counted(n, 'world')} cannot separate {n_pairs} pairs: that takes {needed}." if n < needed else ""
    return _Matrix(
        pairs.graph,
        variants,
        rows,
        n_pairs,
        too_few,
        len(pairs.variants) - len(variants),
        len(variants) <= _MAX_WIDE,
    )


def _pair_cell(pairs: AllPairs, pair: Pair, better: Better, *, is_upper: bool) -> _PairCell:
    if pair[0] == pair[1]:
        return _PairCell()
    found = pairs.differences.get(pair)
    if found is None:
        return _PairCell([OWN_FRAMES if pair in pairs.own_frames else NO_COMMON_WORLD])
    verdict = "unclear"
    if found.is_clear and better != "neither":
        verdict = "better" if (found.mean > 0) == (better == "higher") else "worse"
    if is_upper:
        difference = estimated(found.mean, found.low, found.high, signed=True)
        mean, _, interval = difference.partition(" ")
        small = [TOO_SMALL] if found.is_significant and not found.matters else []
        return _PairCell([mean, interval, *small], verdict)
    p = [p_text(found.significance.p_holm)] if found.significance else []
    return _PairCell(
        [f"{found.won}–{found.tied}–{found.lost}", estimate_text(found.probability_better), *p],
        verdict,
    )


_PALETTE = ("#aab4c0", BASE, *METHODS)
_REST, _REST_COLOUR = "all others", "#dfe3e8"


@dataclass(frozen=True)
class _GraphTimes:
    """Bars of the first ``n_shown`` rows, and a table of the times of all in milliseconds by variant and stage."""

    name: str
    colours: Mapping[str, str]
    bars: Markup
    n_shown: int
    n_rows: int
    table: Markup


def timing(study: StudyResults) -> Markup:
    """Return bars and a table of each graph, of the rows that have runs."""
    graphs = []
    for graph in study.plan.graphs:
        rows = {row.case.variant: row.p50_ms for row in study.own_rows(graph) if row.p50_ms}
        if rows:
            graphs.append(_graph_times(graph, rows))
    return rendered("step_times.html", graphs=graphs)


def _graph_times(graph: str, rows: Mapping[str, Mapping[str, float]]) -> _GraphTimes:
    stages = list(dict.fromkeys(stage for times in rows.values() for stage in times))
    colours = _colours(stages, rows)
    shown = {variant: _gathered(times, colours) for variant, times in list(rows.items())[:MAX_ROWS]}
    bars = stacked_bars(shown, colours, "median time of one step, ms")
    columns = [Column("variant"), *(Column(stage, stage, "right") for stage in stages)]
    cells = [
        [variant, *(f"{times[stage]:.2f}" if stage in times else "—" for stage in stages)]
        for variant, times in rows.items()
    ]
    return _GraphTimes(graph, colours, bars, len(shown), len(rows), Table(columns, cells).html("page"))


def _colours(stages: Sequence[str], rows: Mapping[str, Mapping[str, float]]) -> dict[str, str]:
    """Return a colour for each stage, of very many for those that take longest, and one for all others."""
    longest = {stage: max(times.get(stage, 0.0) for times in rows.values()) for stage in stages}
    kept = set(sorted(stages, key=lambda stage: -longest[stage])[: len(_PALETTE)])
    colours = dict(zip((stage for stage in stages if stage in kept), _PALETTE, strict=False))
    return colours if len(kept) == len(stages) else {**colours, _REST: _REST_COLOUR}


def _gathered(times: Mapping[str, float], colours: Mapping[str, str]) -> dict[str, float]:
    """Return the times of the stages that have a colour, and the sum of the others'."""
    own = {stage: times[stage] for stage in colours if stage in times}
    rest = sum(value for stage, value in times.items() if stage not in colours)
    return {**own, _REST: rest} if rest else own


def decomposition(study: StudyResults) -> Markup:
    """Return the chart and the tables of a decomposed study; nothing for other studies."""
    found = losses(study.plan, study.records)
    if not found:
        return Markup("")
    told = [of for of in found if not of.is_cut_off]
    return rendered(
        "decomposition.html",
        chart=base64.b64encode(decomposition_picture(told, "svg")).decode("ascii") if told else "",
        answers=[" ".join(sentences(study.plan, of)) for of in found],
        notes=list(notes(study.plan, found)),
        tables=[(table.title, table.html("page")) for table in map(loss_table, told)],
    )
