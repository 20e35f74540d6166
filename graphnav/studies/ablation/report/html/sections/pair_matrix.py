"""All pairs of variants by the metric that decides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from graphnav.core.stage import Better
from graphnav.studies.ablation.report.html.number_text import counted, estimate_text, estimated
from graphnav.studies.ablation.report.html.render import rendered
from graphnav.studies.ablation.report.html.sections.forest_plot import NO_COMMON_WORLD, shown_variants
from graphnav.studies.ablation.report.html.study_results import StudyResults
from graphnav.studies.ablation.report.legend import OWN_FRAMES
from graphnav.studies.ablation.report.number_format import TOO_SMALL, p_text
from graphnav.studies.ablation.results import AllPairs, Pair, all_pairs, min_worlds

_MIN_VARIANTS = 3
"""The pairs of fewer variants are in the tables of differences from the base."""
_MAX_VARIANTS = 60
"""Of more, the pairs are not compared: there are thousands, and no worlds that could tell them apart."""
_MAX_OPEN = 8
"""Variants of a matrix that is not folded."""


@dataclass(frozen=True)
class _Cell:
    """A pair: above the diagonal its difference, below it how the worlds went."""

    lines: Sequence[str] = ()
    verdict: str = ""


@dataclass(frozen=True)
class _Matrix:
    """The pairs of one graph; rows in the order of the columns."""

    graph: str
    variants: Sequence[str]
    rows: Sequence[tuple[str, Sequence[_Cell]]]
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
        (row, [_cell(pairs, (row, column), better, is_upper=x > y) for x, column in enumerate(variants)])
        for y, row in enumerate(variants)
    ]
    n_pairs = len(pairs.variants) * (len(pairs.variants) - 1) // 2
    n, needed = max((found.n for found in pairs.differences.values()), default=0), min_worlds(n_pairs)
    too_few = f"{counted(n, 'world')} cannot separate {n_pairs} pairs: that takes {needed}." if n < needed else ""
    return _Matrix(
        pairs.graph, variants, rows, n_pairs, too_few, len(pairs.variants) - len(variants), len(variants) <= _MAX_OPEN
    )


def _cell(pairs: AllPairs, pair: Pair, better: Better, *, is_upper: bool) -> _Cell:
    if pair[0] == pair[1]:
        return _Cell()
    found = pairs.differences.get(pair)
    if found is None:
        return _Cell([OWN_FRAMES if pair in pairs.own_frames else NO_COMMON_WORLD])
    verdict = "unclear"
    if found.is_clear and better != "neither":
        verdict = "better" if (found.mean > 0) == (better == "higher") else "worse"
    if is_upper:
        difference = estimated(found.mean, found.low, found.high, signed=True)
        mean, _, interval = difference.partition(" ")
        small = [TOO_SMALL] if found.is_significant and not found.matters else []
        return _Cell([mean, interval, *small], verdict)
    p = [p_text(found.significance.p_holm)] if found.significance else []
    return _Cell(
        [f"{found.won}–{found.tied}–{found.lost}", estimate_text(found.probability_better), *p],
        verdict,
    )
