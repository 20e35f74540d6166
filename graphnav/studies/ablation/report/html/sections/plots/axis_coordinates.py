"""Parallel coordinates: what each combination of two or more axes comes to."""

from __future__ import annotations

from collections.abc import Iterator

from markupsafe import Markup

from graphnav.studies.ablation.report.html.charts import Strand, parallel_chart
from graphnav.studies.ablation.report.html.study_results import StudyResults

_MAX_CHARTS = 8


def axis_coordinates(study: StudyResults) -> list[Markup]:
    """Return a chart for each graph: a line for each variant through its choices to the metric that decides.

    Nothing for studies in which fewer than two axes vary. Conditions do not vary within a graph.
    """
    metric = study.deciding
    if metric is None:
        return []
    return [
        parallel_chart(graph, axes, strands, study.plan.label(metric), study.plan.better(metric))
        for graph, axes, strands in _by_graph(study, metric)
    ][:_MAX_CHARTS]


def _by_graph(study: StudyResults, metric: str) -> Iterator[tuple[str, dict[str, list[str]], list[Strand]]]:
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
