"""The first screen: question, answer, setup, and the chart that shows the answer."""

from __future__ import annotations

from markupsafe import Markup

from graphnav.ablation.report.html.number_text import counted
from graphnav.ablation.report.html.render import rendered
from graphnav.ablation.report.html.sections.forest_plot import chart_key, forest
from graphnav.ablation.report.html.sections.headline import headline, verdicts
from graphnav.ablation.report.html.sections.plots import deciding_sweeps
from graphnav.ablation.report.html.sections.variant_lists import reference_values, variants_by_verdict
from graphnav.ablation.report.html.study_results import StudyResults
from graphnav.ablation.report.legend import too_few_worlds, worlds_of_graphs


def overview(study: StudyResults) -> Markup:
    """Return the head of the page."""
    metric = study.deciding
    n, n_planned = study.n_runs, study.plan.n_jobs
    is_finished = n >= n_planned
    missing = f"not finished: so far {n} of {counted(n_planned, 'run')}"
    nothing = Markup("")
    charts = answer = verdicts_drawn = references = nothing
    if metric is not None:
        charts = deciding_sweeps(study) + forest(study, metric) + chart_key()
    if metric is not None and n:
        found = verdicts(study, metric)
        answer = headline(study, metric, found)
        verdicts_drawn, references = variants_by_verdict(study, metric, found), reference_values(study, metric)
    return rendered(
        "first_screen.html",
        plan=study.plan,
        is_finished=is_finished,
        state=f"finished: {counted(n, 'run')}" if is_finished else missing,
        answer=answer,
        verdicts=verdicts_drawn,
        references=references,
        setup=_setup(study),
        too_few=too_few_worlds(study.plan, study.comparison),
        charts=charts,
    )


def _setup(study: StudyResults) -> list[tuple[str, str]]:
    plan = study.plan
    shared = sum(bool(case.same_as) for case in plan.cases)
    same = f"; {shared} of {len(plan.cases)} cases are the same graph as another" if shared else ""
    return [
        ("worlds", f"seeds {worlds_of_graphs(plan)}, the same for all variants"),
        ("graphs", ", ".join(plan.sources)),
        *([("compared under the same", ", ".join(plan.within))] if plan.within else []),
        ("variants", f"{len(plan.variants)}{same}"),
        ("base", plan.base),
        ("decides", _deciding(study)),
    ]


def _deciding(study: StudyResults) -> str:
    metric, plan = study.deciding, study.plan
    if not metric:
        return "no metric"
    smallest = plan.min_difference(metric)
    matters = f", differences matter from {smallest:g}" if smallest else ""
    return f"{plan.label(metric)}, {plan.better(metric)} is better{matters}"
