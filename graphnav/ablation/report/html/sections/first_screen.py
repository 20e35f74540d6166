"""The first screen: question, answer, setup, and the chart that shows the answer."""

from __future__ import annotations

from graphnav.ablation.report.html.markup import Html, esc, tag
from graphnav.ablation.report.html.number_text import counted
from graphnav.ablation.report.html.sections.forest_plot import chart_key, forest
from graphnav.ablation.report.html.sections.headline import headline, verdicts
from graphnav.ablation.report.html.sections.parameter_sweeps import deciding_sweeps
from graphnav.ablation.report.html.sections.variant_lists import reference_values, variants_by_verdict
from graphnav.ablation.report.html.study_results import StudyResults
from graphnav.ablation.report.legend import seeds_text
from graphnav.ablation.results import MIN_WORLDS


def overview(study: StudyResults) -> Html:
    """Return the head of the page."""
    plan = study.plan
    parts = [
        tag("p", "Ablation study ", tag("b", esc(plan.name)), _state(study), class_="eyebrow"),
        tag("h1", esc(plan.about or plan.name)),
        _answer(study),
        _facts(study),
    ]
    if study.deciding is not None:
        parts += [deciding_sweeps(study), forest(study, study.deciding), chart_key()]
    return tag("header", *parts)


def _answer(study: StudyResults) -> Html:
    metric = study.deciding
    if metric is None or not study.n_runs:
        return tag("p", "No run is there yet, so there is no answer.", class_="lead")
    found = verdicts(study, metric)
    said = tag("p", headline(study, metric, found), class_="lead")
    return said + variants_by_verdict(study, metric, found) + reference_values(study, metric)


def _state(study: StudyResults) -> Html:
    n, wanted = study.n_runs, study.plan.n_jobs
    if n >= wanted:
        return tag("span", f"finished: {counted(n, 'run')}", class_="pill")
    return tag("span", f"not finished: so far {n} of {counted(wanted, 'run')}", class_="pill warn")


def _facts(study: StudyResults) -> Html:
    plan = study.plan
    shared = sum(bool(case.same_as) for case in plan.cases)
    facts = [
        ("worlds", f"seeds {seeds_text(plan.seeds)}, the same for all variants"),
        ("graphs", ", ".join(plan.sources)),
        *([("compared under the same", ", ".join(plan.within))] if plan.within else []),
        (
            "variants",
            f"{len(plan.variants)}"
            + (f"; {shared} of {len(plan.cases)} cases are the same graph as another" if shared else ""),
        ),
        ("base", plan.base),
        (
            "decides",
            f"{plan.label(study.deciding)}, {plan.better(study.deciding)} is better" if study.deciding else "no metric",
        ),
    ]
    drawn = [tag("div", tag("dt", esc(name)), tag("dd", esc(text))) for name, text in facts]
    return tag("dl", *drawn, class_="facts") + _warning(study.n_seeds)


def _warning(n: int) -> Html:
    if n == 1:
        return tag("p", "One world: no interval means anything, and no difference does.", class_="note warn")
    if n < MIN_WORLDS:
        said = f"{n} worlds are too few to call a difference one: that takes {MIN_WORLDS}."
        return tag("p", said, class_="note warn")
    return ""
