"""Charts of all metrics but the deciding one, and of numeric axes."""

from __future__ import annotations

from markupsafe import Markup

from graphnav.studies.ablation.report.html.render import rendered
from graphnav.studies.ablation.report.html.sections.forest_plot import chart_key, forest
from graphnav.studies.ablation.report.html.sections.plots.axis_coordinates import axis_coordinates
from graphnav.studies.ablation.report.html.sections.plots.parameter_sweeps import sweeps
from graphnav.studies.ablation.report.html.sections.plots.performance_profiles import profiles
from graphnav.studies.ablation.report.html.study_results import StudyResults

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
