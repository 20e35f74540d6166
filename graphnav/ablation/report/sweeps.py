"""Figures against the axes whose choices are numbers: where a thing breaks."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from graphnav.ablation.plan import Case
from graphnav.ablation.report.html import Html, esc, tag
from graphnav.ablation.report.lines import Point, Series, line_chart
from graphnav.ablation.report.looks import BASE, METHODS
from graphnav.ablation.report.material import Material

_NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
_MOST_LINES = 8
_MOST_CHARTS = 8
"""Of one axis on one graph."""


def sweeps(material: Material) -> Html:
    """Return line charts for every axis that has a number in each label, three at least; none for others."""
    parts = []
    for axis, labels in material.plan.axes.items():
        places = axis_numbers(labels)
        if places is None:
            continue
        for graph in material.plan.graphs:
            charts = list(_charts(material, graph, axis, places))[:_MOST_CHARTS]
            if charts:
                parts += [tag("h3", esc(f"{axis} on {graph}")), tag("div", *charts, class_="grid")]
    return "".join(parts)


def axis_numbers(labels: Sequence[str]) -> dict[str, float] | None:
    """Return the one number of each label, None unless there are three different ones and one in every label."""
    found = {label: _NUMBER.findall(label.rpartition("=")[2]) for label in labels}
    numbers = {label: float(of[0]) for label, of in found.items() if len(of) == 1}
    return numbers if len(numbers) == len(labels) and len({*numbers.values()}) >= 3 else None


def _charts(material: Material, graph: str, axis: str, places: dict[str, float]) -> Iterator[Html]:
    lines = _lines(material, graph, axis)
    for name, figures in _families(material.figures).items():
        one = len(figures) == 1
        wanted = [(figure, others, cases) for figure in figures for others, cases in lines.items()]
        series: list[Series] = []
        for figure, others, cases in wanted[:_MOST_LINES]:
            points = sorted(_points(material, figure, axis, cases, places), key=lambda point: point.x)
            if not points:
                continue
            called = others if one else figure.rpartition(".")[0] + (f", {others}" if others and len(lines) > 1 else "")
            colour = (BASE, *METHODS)[len(series) % (1 + len(METHODS))]
            special = any(case.role != "method" for case in cases)
            series.append(Series(called, points, colour, is_dashed=special))
        if series:
            yield line_chart(figures[0] if one else name, axis, series)


def _lines(material: Material, graph: str, axis: str) -> dict[str, list[Case]]:
    """Return the cases of each choice of the other axes."""
    found: dict[str, list[Case]] = {}
    for case in material.plan.cases:
        if case.graph == graph:
            others = ", ".join(label for name, label in case.labels.items() if name != axis)
            found.setdefault(others, []).append(case)
    return {others: cases for others, cases in found.items() if len({case.labels[axis] for case in cases}) >= 3}


def _families(figures: Sequence[str]) -> dict[str, list[str]]:
    """Return figures of the same name together: a detector each."""
    found: dict[str, list[str]] = {}
    for figure in figures:
        found.setdefault(figure if " " in figure else figure.rpartition(".")[2], []).append(figure)
    return found


def _points(
    material: Material, figure: str, axis: str, cases: Sequence[Case], places: dict[str, float]
) -> Iterator[Point]:
    for case in cases:
        found = material.estimate(case.graph, case.variant, figure)
        if found is not None:
            yield Point(places[case.labels[axis]], found.mean, found.low, found.high)
