"""The first screen: the question, the answer, how it was asked, and the chart that shows it."""

from __future__ import annotations

from graphnav.ablation.results.compare_variants import LEAST_WORLDS
from graphnav.ablation.report.legend import seeds_text
from graphnav.ablation.report.html.sections.forest_plot import forest, key
from graphnav.ablation.report.html.sections.headline import lead, verdicts
from graphnav.ablation.report.html.markup import Html, esc, tag
from graphnav.ablation.report.html.study_results import Material
from graphnav.ablation.report.html.number_text import counted
from graphnav.ablation.report.html.sections.variant_lists import checks, sides
from graphnav.ablation.report.html.sections.parameter_sweeps import deciding_sweeps


def answer(material: Material) -> Html:
    """Return the head of the page."""
    plan = material.plan
    parts = [
        tag("p", "Ablation study ", tag("b", esc(plan.name)), _state(material), class_="eyebrow"),
        tag("h1", esc(plan.about or plan.name)),
        _answer(material),
        _facts(material),
    ]
    if material.deciding is not None:
        parts += [deciding_sweeps(material), forest(material, material.deciding), key()]
    return tag("header", *parts)


def _answer(material: Material) -> Html:
    figure = material.deciding
    if figure is None or not material.n_runs:
        return tag("p", "No run is there yet, so there is no answer.", class_="lead")
    found = verdicts(material, figure)
    said = tag("p", lead(material, figure, found), class_="lead")
    return said + sides(material, figure, found) + checks(material, figure)


def _state(material: Material) -> Html:
    n, wanted = material.n_runs, material.plan.n_jobs
    if n >= wanted:
        return tag("span", f"finished: {counted(n, 'run')}", class_="pill")
    return tag("span", f"not finished: so far {n} of {counted(wanted, 'run')}", class_="pill warn")


def _facts(material: Material) -> Html:
    plan = material.plan
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
            f"{material.deciding}, {plan.better(material.deciding)} is better" if material.deciding else "no figure",
        ),
    ]
    drawn = [tag("div", tag("dt", esc(name)), tag("dd", esc(text))) for name, text in facts]
    return tag("dl", *drawn, class_="facts") + _warning(material.n_seeds)


def _warning(n: int) -> Html:
    if n == 1:
        return tag("p", "One world: no interval means anything, and no difference does.", class_="note warn")
    if n < LEAST_WORLDS:
        said = f"{n} worlds are too few to call a difference one: that takes {LEAST_WORLDS}."
        return tag("p", said, class_="note warn")
    return ""
