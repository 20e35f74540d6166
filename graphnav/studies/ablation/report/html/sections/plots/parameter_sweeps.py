"""Metrics over the axes whose choices are numbers."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

from markupsafe import Markup

from graphnav.studies.ablation.plan import Case, Plan
from graphnav.studies.ablation.report.html.charts import FULL_WIDTH, HALF_WIDTH, Point, Series, line_chart
from graphnav.studies.ablation.report.html.render import rendered
from graphnav.studies.ablation.report.html.study_results import StudyResults
from graphnav.studies.ablation.report.html.variant_style import BASE, METHODS

_NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
_MAX_LINES = 10
_MAX_CHARTS = 8
"""Of one axis on one graph."""
_MAX_FIRST = 4


@dataclass(frozen=True)
class Chart:
    """The content of a line chart."""

    title: str
    axis: str
    series: Sequence[Series]


def deciding_sweeps(study: StudyResults) -> Markup:
    """Return line charts of the metric that decides, with those of the same name; nothing without numeric axes."""
    kin = _family(study.deciding or "")
    metrics = [metric for metric in study.metrics if _family(metric) == kin]
    charts = [chart for _, of in _by_axis(study, metrics) for chart in of]
    return _grids([("", charts[:_MAX_FIRST])])


def sweeps(study: StudyResults) -> Markup:
    """Return line charts of all other metrics."""
    kin = _family(study.deciding or "")
    metrics = [metric for metric in study.metrics if _family(metric) != kin]
    return _grids([(title, of[:_MAX_CHARTS]) for title, of in _by_axis(study, metrics)])


def axis_numbers(labels: Sequence[str]) -> dict[str, float] | None:
    """Return the one number of each label, None unless there are three different ones and one in every label."""
    found = {label: _NUMBER.findall(label.rpartition("=")[2]) for label in labels}
    numbers = {label: float(of[0]) for label, of in found.items() if len(of) == 1}
    return numbers if len(numbers) == len(labels) and len({*numbers.values()}) >= 3 else None


def _grids(groups: Iterable[tuple[str, Sequence[Chart]]]) -> Markup:
    return rendered("sweeps.html", groups=[(title, _drawn(charts)) for title, charts in groups])


def _drawn(charts: Sequence[Chart]) -> list[Markup]:
    width = FULL_WIDTH if len(charts) == 1 else HALF_WIDTH
    return [line_chart(chart.title, chart.axis, chart.series, width) for chart in charts]


def _by_axis(study: StudyResults, metrics: Sequence[str]) -> Iterator[tuple[str, list[Chart]]]:
    """Yield the charts of every axis that is one of numbers, graph by graph."""
    for axis, labels in study.plan.axes.items():
        places = axis_numbers(labels)
        if places is None:
            continue
        by_graph = _by_graph(study.plan, axis)
        for graph, cases in by_graph.items():
            lines = _lines(study.plan, cases, axis)
            where = f" on {graph}" if len(by_graph) > 1 else ""
            if charts := list(_charts(study, lines, axis, places, metrics, where)):
                yield f"{axis} on {graph}", charts


def _by_graph(plan: Plan, axis: str) -> dict[str, list[Case]]:
    """Return the cases among which an axis varies and no condition else, by graph and those conditions."""
    found: dict[str, list[Case]] = {}
    for case in plan.cases:
        others = [case.labels[name] for name in plan.within if name != axis]
        found.setdefault(", ".join([case.source, *others]), []).append(case)
    return found


def _charts(
    study: StudyResults,
    lines: Mapping[str, Sequence[Case]],
    axis: str,
    places: Mapping[str, float],
    metrics: Sequence[str],
    where: str,
) -> Iterator[Chart]:
    """Yield a chart for every name of a metric: a line for each stage that has it and each choice of other axes."""
    families: dict[str, list[str]] = {}
    for metric in metrics:
        families.setdefault(_family(metric), []).append(metric)
    for name, kin in families.items():
        series: list[Series] = []
        for metric, (others, cases) in list(product(kin, lines.items()))[:_MAX_LINES]:
            points = sorted(_points(study, metric, axis, cases, places), key=lambda point: point.x)
            words = [metric.rpartition(".")[0]] * (len(kin) > 1) + [others] * (len(lines) > 1)
            special = any(case.role != "method" for case in cases)
            if points:
                colour = (BASE, *METHODS)[len(series) % (1 + len(METHODS))]
                series.append(Series(", ".join(words), points, colour, is_dashed=special))
        if series:
            yield Chart((kin[0] if len(kin) == 1 else name) + where, axis, series)


def _lines(plan: Plan, cases: Sequence[Case], axis: str) -> dict[str, list[Case]]:
    """Return the cases of each choice of the other axes, where there are enough for a line."""
    found: dict[str, list[Case]] = {}
    for case in cases:
        others = ", ".join(label for name, label in case.labels.items() if name not in {axis, *plan.within})
        found.setdefault(others, []).append(case)
    return {others: cases for others, cases in found.items() if len({case.labels[axis] for case in cases}) >= 3}


def _family(metric: str) -> str:
    """Return what metrics of several stages have in common: the name behind the stage's."""
    return metric if " " in metric else metric.rpartition(".")[2]


def _points(
    study: StudyResults, metric: str, axis: str, cases: Sequence[Case], places: Mapping[str, float]
) -> Iterator[Point]:
    for case in cases:
        found = study.estimate(case.graph, case.variant, metric)
        if found is not None:
            yield Point(places[case.labels[axis]], found.mean, found.low, found.high)
