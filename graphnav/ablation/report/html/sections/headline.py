"""The answer in a sentence, derived from the intervals alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from graphnav.ablation.report.html.markup import Html, esc, tag
from graphnav.ablation.report.html.number_text import counted, estimated, means_text
from graphnav.ablation.report.html.sections.forest_plot import missing_reason
from graphnav.ablation.report.html.study_results import StudyResults
from graphnav.ablation.report.html.verdict import Verdict, verdict_of
from graphnav.ablation.results import Row
from graphnav.stage import Role

Found = Mapping[tuple[str, str], tuple[Verdict, Row]]
"""Verdicts and rows by variant and graph."""

_MAX_NAMES = 3


def verdicts(study: StudyResults, metric: str, role: Role = "method") -> Found:
    """Return the verdicts of a metric on all variants of a role that have runs of their own, but the base."""
    better = study.plan.better(metric)
    return {
        (row.case.variant, graph): (verdict_of(row, metric, better), row)
        for graph in study.plan.graphs
        for row in study.own_rows(graph)
        if row.case.role == role and not row.case.is_base
    }


def headline(study: StudyResults, metric: str, found: Found) -> Html:
    """Return what the base does and whether anything does better."""
    rivals = list(dict.fromkeys(variant for variant, _ in found))
    if len(rivals) == 1:
        return " ".join(_paired(study, metric, verdict, row) for verdict, row in found.values())
    sides = {side: [v for v in rivals if _side(found, v) == side] for side in ("better", "mixed", "worse")}
    clauses = []
    if sides["better"]:
        clauses.append(f"{_names(sides['better'])} better")
    if sides["mixed"]:
        clauses.append(f"{_names(sides['mixed'])} better on some {_places(study)} and worse on others")
    if rivals and not clauses:
        clauses.append(f"None of the {len(rivals)} others is better")
    if sides["worse"]:
        n = len(sides["worse"])
        clauses.append(
            f"{_names(sides['worse'])} worse"
            if n <= _MAX_NAMES
            else f"{n} of {len(rivals)} are worse"
            if n < len(rivals)
            else "all are worse"
        )
    said = f" {'; '.join(clauses)}." if clauses else ""
    return f"{name(study.plan.base)} has {tag('b', esc(metric))} {_everywhere(study, metric)}.{said}"


def _side(found: Found, variant: str) -> str:
    """Return what a variant is over all graphs: better or worse somewhere, both ("mixed"), or neither."""
    sides = {verdict for (called, _), (verdict, _) in found.items() if called == variant}
    if {"better", "worse"} <= sides:
        return "mixed"
    return next((side for side in ("better", "worse") if side in sides), "neither")


def _paired(study: StudyResults, metric: str, verdict: Verdict, row: Row) -> Html:
    """Return what one rival does, and how that differs from the base."""
    where = f" on {esc(row.case.graph)}" if len(study.plan.graphs) > 1 else ""
    estimate, difference = row.estimates.get(metric), row.differences.get(metric)
    if estimate is None or difference is None:
        return f"{name(row.case.variant)}{where}: {esc(missing_reason(row))}."
    value = estimated(estimate.mean, estimate.low, estimate.high)
    change = estimated(difference.mean, difference.low, difference.high, signed=True)
    words = {
        "better": "better than the base",
        "worse": "worse than the base",
        "different": "different from the base",
        "unclear": f"no difference that {counted(difference.n, 'world')} can tell",
    }.get(verdict, f"{counted(difference.n, 'world')} cannot tell")
    said = f"{tag('b', esc(metric))} {value}, {change} against {name(study.plan.base)}"
    return f"{name(row.case.variant)}{where}: {said} \N{EM DASH} {words}."


def _everywhere(study: StudyResults, metric: str) -> Html:
    """Return what the base has on each graph, on many the least and the greatest."""
    graphs, base = study.plan.graphs, study.plan.base
    found = {graph: of for graph in graphs if (of := study.estimate(graph, base, metric)) is not None}
    if len(found) > _MAX_NAMES:
        return f"{means_text([of.mean for of in found.values()])} on {len(found)} {_places(study)}"
    said = [
        estimated(of.mean, of.low, of.high) + (f" on {esc(graph)}" if len(graphs) > 1 else "")
        for graph, of in found.items()
    ]
    return ", ".join(said) or "in no run yet"


def _places(study: StudyResults) -> str:
    """Return what tells the tables of a study apart."""
    plan = study.plan
    return "graphs" if not plan.within else "conditions" if len(plan.sources) == 1 else "graphs and conditions"


def name(variant: str) -> Html:
    """Return a variant's name as sentences show it."""
    return tag("span", esc(variant), class_="variant")


def _names(variants: Sequence[str]) -> Html:
    """Return names with the verb that they take."""
    if len(variants) == 1:
        return f"{name(variants[0])} is"
    shown = [name(variant) for variant in variants[:_MAX_NAMES]]
    if len(variants) > _MAX_NAMES:
        return f"{', '.join(shown)} and {len(variants) - _MAX_NAMES} more are"
    return f"{', '.join(shown[:-1])} and {shown[-1]} are"
