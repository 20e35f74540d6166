"""The mean of every variant with its interval, graph by graph."""

from __future__ import annotations

import math
from collections.abc import Sequence

from markupsafe import Markup

from graphnav.core.runner import Outcome
from graphnav.studies.ablation.report.html.charts import PANELS, Mark, Panel, whisker_chart
from graphnav.studies.ablation.report.html.rendering import estimate_text, rendered
from graphnav.studies.ablation.report.html.study_results import WORDS, StudyResults, badge_of, verdict_of
from graphnav.studies.ablation.results import Row

MAX_ROWS = 24
NO_COMMON_WORLD = "no common world"
"""In place of a difference of variants that share none."""


def forest(study: StudyResults, metric: str, *, with_worlds: bool = False) -> Markup:
    """Return charts of a metric; ``with_worlds``: a small dot for every world, coloured by how its run ended."""
    shown = shown_variants(study, metric)
    labels = {variant: _badge(study, variant) for variant in shown}
    graphs = study.plan.graphs
    x_label = f"{study.plan.label(metric)}, {study.plan.better(metric)} is better"
    charts = []
    columns = math.ceil(len(graphs) / math.ceil(len(graphs) / PANELS))
    for begin in range(0, len(graphs), columns):
        some = graphs[begin : begin + columns]
        panels = [_panel(study, graph, metric, with_worlds=with_worlds) for graph in some]
        charts.append(whisker_chart(labels, panels, x_label, f"{metric} of every variant", columns))
    return rendered("forest.html", charts=charts, n_left_out=len(study.own_variants) - len(shown))


def shown_variants(study: StudyResults, metric: str) -> Sequence[str]:
    """Return the variants with runs of their own; of very many the base, baselines, oracles and the best."""
    every = study.own_variants
    if len(every) <= MAX_ROWS:
        return every
    plan = study.plan
    special = {case.variant for case in plan.cases if case.is_base or case.role != "method"}
    kept = [variant for variant in every if variant in special][: MAX_ROWS // 2]
    sign = -1.0 if plan.better(metric) != "lower" else 1.0

    def rank(variant: str) -> float:
        means = [found.mean for graph in plan.graphs if (found := study.estimate(graph, variant, metric))]
        return sign * sum(means) / len(means) if means else float("inf")

    best = sorted((variant for variant in every if variant not in special), key=rank)[: MAX_ROWS - len(kept)]
    return [variant for variant in every if variant in {*kept, *best}]


def _badge(study: StudyResults, variant: str) -> str:
    return next(badge_of(row.case) for row in study.comparison.rows if row.case.variant == variant)


def _panel(study: StudyResults, graph: str, metric: str, *, with_worlds: bool) -> Panel:
    rows = study.own_rows(graph)
    marks: dict[str, Mark | str] = {
        row.case.variant: f"the same graph as {row.case.same_as}"
        for row in study.comparison.of_graph(graph)
        if row.case.same_as
    }
    marks |= {row.case.variant: _mark(study, row, metric, with_worlds=with_worlds) for row in rows}
    base = study.estimate(graph, study.plan.base, metric)
    return Panel(graph, marks, base.mean if base else None)


def _mark(study: StudyResults, row: Row, metric: str, *, with_worlds: bool) -> Mark | str:
    found = row.estimates.get(metric)
    if found is None:
        return missing_reason(row)
    verdict = verdict_of(row, metric, study.plan.better(metric))
    title = f"{row.case.variant}: {estimate_text(found)} over {found.n} worlds, {WORDS[verdict]}"
    points: list[tuple[float, str]] = []
    if with_worlds:
        case = row.case
        values = study.values(case.graph, case.variant, metric)
        outcomes = {run.seed: run.outcome for run in study.runs.get((case.graph, case.variant), ())}
        points = [(value, outcomes[seed]) for seed, value in values.items()]
    look = f"mark {verdict} {row.case.role}"
    return Mark(found.mean, found.low, found.high, look, title, points)


def missing_reason(row: Row) -> str:
    """Return why a row has no value."""
    failed = row.outcomes.get(Outcome.FAILED, 0)
    if failed and failed == row.runs:
        return f"failed in all of {row.runs} worlds"
    return "undefined in all runs" if row.runs else "no run yet"


def chart_key(*, with_worlds: bool = False) -> Markup:
    """Return what the marks mean."""
    kinds = [
        ("base method", "the base"), ("better method", "better than the base"), ("worse method", "worse"),
        ("unclear method", "no difference that these worlds can tell"), ("unclear baseline", "baseline"),
        ("unclear oracle", "oracle"),
    ]  # fmt: skip
    shown = [{"look": look, "text": text, "is_oracle": "oracle" in look} for look, text in kinds]
    rest = "Whiskers: 95 % intervals. Dashed: the base."
    if with_worlds:
        rest += " Small dots: worlds, red where the robot touched something. Only what decides is tested and coloured."
    return rendered("chart_key.html", kinds=shown, rest=rest)
