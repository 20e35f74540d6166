"""Plots of metrics: over axes, as profiles, world by world."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

from markupsafe import Markup

from graphnav.studies.ablation.plan import Case, Plan
from graphnav.studies.ablation.report.html.charts import (
    FULL_WIDTH,
    HALF_WIDTH,
    Point,
    Series,
    Steps,
    Strand,
    line_chart,
    parallel_chart,
    profile_chart,
)
from graphnav.studies.ablation.report.html.forest_plot import chart_key, forest, shown_variants
from graphnav.studies.ablation.report.html.rendering import rendered
from graphnav.studies.ablation.report.html.study_results import BASE, METHODS, StudyResults, colours_of

_MAX_PARALLEL = 8


def axis_coordinates(study: StudyResults) -> list[Markup]:
    """Return a chart for each graph: a line for each variant through its choices to the metric that decides.

    Nothing for studies in which fewer than two axes vary. Conditions do not vary within a graph.
    """
    metric = study.deciding
    if metric is None:
        return []
    return [
        parallel_chart(graph, axes, strands, study.plan.label(metric), study.plan.better(metric))
        for graph, axes, strands in _strands_by_graph(study, metric)
    ][:_MAX_PARALLEL]


def _strands_by_graph(study: StudyResults, metric: str) -> Iterator[tuple[str, dict[str, list[str]], list[Strand]]]:
    """Yield the varying axes of each graph with their choices, and its variants."""
    plan = study.plan
    for graph in plan.graphs:
        rows = [row for row in study.comparison.of_graph(graph) if metric in row.estimates]
        axes = {
            axis: [label for label in labels if any(row.case.labels[axis] == label for row in rows)]
            for axis, labels in plan.axes.items()
            if axis not in plan.within
        }
        varying = {axis: labels for axis, labels in axes.items() if len(labels) > 1}
        if len(varying) > 1:
            strands = [
                Strand(row.case.variant, [row.case.labels[axis] for axis in varying], row.estimates[metric].mean)
                for row in rows
            ]
            yield graph, varying, strands


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


_MAX_PROFILES = 4
_UNITS = ("", "ratio")
"""Of shares; a clearance may be below 1 m by chance."""


def profiles(study: StudyResults) -> Markup:
    """Return, graph by graph, the profiles of metrics from 0 to 1 of which higher is better [Dolan]_ [Agarwal]_.

    A failed run counts as the metric declares, SPL as 0: so a profile starts at the share of drives that arrived. A
    mean hides whether a variant is a little worse in every world or fails in some.

    References
    ----------
    .. [Dolan] E. D. Dolan, J. J. More, Benchmarking Optimization Software with Performance Profiles, Mathematical
       Programming 91, 2002.
    .. [Agarwal] R. Agarwal et al., Deep Reinforcement Learning at the Edge of the Statistical Precipice, NeurIPS 2021.
    """
    metrics = [metric for metric in study.metrics if _is_graded_share(study, metric)][:_MAX_PROFILES]
    colours = colours_of(study.plan)
    variants = list(dict.fromkeys(v for metric in metrics for v in shown_variants(study, metric)))
    return rendered(
        "profiles.html",
        metrics=[(metric, list(_profiles_of(study, metric, colours))) for metric in metrics],
        colours=[(variant, colours[variant]) for variant in variants],
    )


def _is_graded_share(study: StudyResults, metric: str) -> bool:
    """Return whether a metric is between 0 and 1, not only one of them, and better if higher.

    Not one of the frames that a run meets, where variants meet frames of their own.
    """
    if study.plan.better(metric) != "higher" or study.plan.metric(metric).unit not in _UNITS:
        return False
    if any(metric in row.own_frames for row in study.comparison.rows):
        return False
    values = {value for key in study.runs for value in study.values(*key, metric).values()}
    return bool(values - {0.0, 1.0}) and min(values) >= 0.0 and max(values) <= 1.0


def _profiles_of(study: StudyResults, metric: str, colours: dict[str, str]) -> Iterator[Markup]:
    roles = {case.variant: case.role for case in study.plan.cases}
    base = study.plan.base
    for graph in study.plan.graphs:
        own = {row.case.variant for row in study.own_rows(graph)}
        steps = [
            Steps(variant, values, colours[variant], is_dashed=roles[variant] != "method")
            for variant in sorted(shown_variants(study, metric), key=lambda name: name == base)
            if variant in own and (values := sorted(study.values(graph, variant, metric).values()))
        ]
        if steps:
            yield profile_chart(graph, f"{study.plan.label(metric)} of at least", steps)


_MAX_METRICS = 8
_OPEN = 3


def plots(study: StudyResults) -> Markup:
    """Return the lines over numeric axes, all axes together, profiles, then dots with every world."""
    metrics = [name for name in study.metrics[: 1 + _MAX_METRICS] if _has_worlds(study, name)]
    return rendered(
        "metric_plots.html",
        sweeps=sweeps(study),
        coordinates=axis_coordinates(study),
        profiles=profiles(study),
        key=chart_key(with_worlds=True) if metrics else "",
        charts=[(metric, forest(study, metric, with_worlds=True)) for metric in metrics],
        n_open=_OPEN,
        n_left_out=len(study.metrics) - 1 - _MAX_METRICS,
    )


def _has_worlds(study: StudyResults, metric: str) -> bool:
    """Return whether a metric shows more than the first screen did: it is another one, or not binary."""
    if metric != study.deciding:
        return True
    return any(value not in {0.0, 1.0} for key in study.runs for value in study.values(*key, metric).values())
