"""Performance profiles: in which share of runs a metric is at least so good."""

from __future__ import annotations

from collections.abc import Iterator

from markupsafe import Markup

from graphnav.studies.ablation.report.html.charts import Steps, profile_chart
from graphnav.studies.ablation.report.html.render import rendered
from graphnav.studies.ablation.report.html.sections.forest_plot import shown_variants
from graphnav.studies.ablation.report.html.study_results import StudyResults
from graphnav.studies.ablation.report.html.variant_style import colours_of

_MAX_METRICS = 4
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
    metrics = [metric for metric in study.metrics if _is_graded_share(study, metric)][:_MAX_METRICS]
    colours = colours_of(study)
    variants = list(dict.fromkeys(v for metric in metrics for v in shown_variants(study, metric)))
    return rendered(
        "profiles.html",
        metrics=[(metric, list(_charts(study, metric, colours))) for metric in metrics],
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


def _charts(study: StudyResults, metric: str, colours: dict[str, str]) -> Iterator[Markup]:
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
