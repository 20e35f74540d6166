"""The table of each graph: means with intervals, differences from the base, outcomes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from graphnav.core.stage import Better
from graphnav.studies.ablation.report.html.number_text import counted, estimate_text, estimated
from graphnav.studies.ablation.report.html.render import rendered
from graphnav.studies.ablation.report.html.study_results import StudyResults
from graphnav.studies.ablation.report.html.variant_style import OUTCOMES, badge_of
from graphnav.studies.ablation.report.html.verdict import Verdict, verdict_of
from graphnav.studies.ablation.report.legend import OWN_FRAMES, worlds_text
from graphnav.studies.ablation.report.number_format import TOO_SMALL, p_text
from graphnav.studies.ablation.results import Difference, Row

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
