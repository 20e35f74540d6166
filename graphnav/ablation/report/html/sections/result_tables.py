"""The table of each graph: means with intervals, differences from the base, outcomes."""

from __future__ import annotations

from graphnav.ablation.report.html.markup import Html, details, esc, table, tag
from graphnav.ablation.report.html.number_text import counted, estimated
from graphnav.ablation.report.html.study_results import StudyResults
from graphnav.ablation.report.html.variant_style import OUTCOMES, badge, badge_of
from graphnav.ablation.report.html.verdict import verdict_of
from graphnav.ablation.results import Row

_MAX_OPEN = 40
"""Rows of a table that stands open."""


def tables(study: StudyResults) -> Html:
    """Return a table for every graph."""
    return "".join(_table(study, graph) for graph in study.plan.graphs)


def _table(study: StudyResults, graph: str) -> Html:
    rows = study.comparison.of_graph(graph)
    head = [esc("variant"), esc("worlds"), esc("how they ended"), *(_head(study, name) for name in study.metrics)]
    drawn = table(head, (_row(study, row) for row in rows), class_="results")
    title = tag("h3", esc(graph))
    return title + drawn if len(rows) <= _MAX_OPEN else title + details(f"{len(rows)} variants", drawn)


def _head(study: StudyResults, metric: str) -> Html:
    return f"{esc(study.plan.label(metric))}<br>" + tag("small", f"{study.plan.better(metric)} is better")


def _row(study: StudyResults, row: Row) -> Html:
    case = row.case
    reasons = "".join(
        tag("div", f"{counted(n, 'run')} failed: {esc(reason)}", class_="reason") for reason, n in row.failures.items()
    )
    name = tag("th", esc(case.variant), badge(badge_of(row)), reasons if not case.same_as else "", scope="row")
    if case.same_as:
        said = f"the same graph as {esc(case.same_as)}: its runs are these"
        return tag("tr", name, tag("td", said, colspan=2 + len(study.metrics), class_="quiet"), class_="same")
    missing = "" if row.runs >= study.n_seeds else f" of {study.n_seeds}"
    cells = [tag("td", f"{row.runs}{missing}", class_="number"), tag("td", _outcomes(row))]
    cells += [tag("td", _metric(study, row, metric)) for metric in study.metrics]
    return tag("tr", name, *cells, class_=f"{case.role} {'base' if case.is_base else ''}".strip())


def _outcomes(row: Row) -> Html:
    found = [(name, row.outcomes[name]) for name in OUTCOMES if row.outcomes.get(name)]
    bar = "".join(tag("i", class_=name, style=f"flex:{n}") for name, n in found)
    return tag("div", bar, class_="bar") + tag("small", ", ".join(f"{n} {name}" for name, n in found))


def _metric(study: StudyResults, row: Row, metric: str) -> Html:
    estimate, difference = row.estimates.get(metric), row.differences.get(metric)
    if estimate is None:
        return tag("span", "\N{EM DASH}", class_="quiet")
    value = tag("b", *_split(estimated(estimate.mean, estimate.low, estimate.high)))
    few = "" if estimate.n >= row.runs else tag("small", f" in {estimate.n}")
    if difference is None:
        return value + few
    look = verdict_of(row, metric, study.plan.better(metric))
    change = estimated(difference.mean, difference.low, difference.high, signed=True)
    more, less = ("higher", "lower") if study.plan.better(metric) == "neither" else ("won", "lost")
    worlds = tag("small", f"{more} {difference.won}, {less} {difference.lost} of {difference.n}")
    return value + few + tag("div", change, class_=f"change {look}") + worlds


def _split(text: str) -> tuple[Html, Html]:
    mean, _, interval = text.partition(" ")
    return mean, tag("span", f" {interval}", class_="interval") if interval else ""
