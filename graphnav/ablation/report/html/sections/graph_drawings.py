"""Drawings of the graphs of a study, with the swapped stages marked."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from graphnav.ablation.plan import Case
from graphnav.ablation.report.html.markup import Html, esc, listed, tag
from graphnav.ablation.report.html.number_text import counted
from graphnav.ablation.report.html.study_results import StudyResults
from graphnav.errors import GraphnavError
from graphnav.graph import graph_of
from graphnav.render import svg_of


def drawings(study: StudyResults) -> Html:
    """Return the base's graph, once for all graphs that are wired alike, and what each marked stage is swapped for."""
    drawn: dict[Html, list[str]] = {}
    for graph in study.plan.graphs:
        cases = [case for case in study.plan.cases if case.graph == graph]
        drawn.setdefault(_drawing(study, cases), []).append(graph)
    return "".join(tag("h3", esc(", ".join(graphs))) + picture for picture, graphs in drawn.items())


def _drawing(study: StudyResults, cases: list[Case]) -> Html:
    base = next(case for case in cases if case.is_base)
    rivals = _rivals(base, cases)
    tuned = _tuned(base, cases)
    notes = {stage: counted(sum(map(bool, uses)), "rival") for stage, uses in rivals.items() if stage in base.uses}
    notes |= {stage: "varied" for stage in tuned if stage in base.uses and stage not in notes}
    lines = [
        f"{tag('b', esc(stage))}: {esc(base.uses.get(stage, 'not in the base'))}; swapped for {esc(_or(uses))}"
        for stage, uses in rivals.items()
    ]
    lines += [f"{tag('b', esc(stage))}: {esc(', '.join(targets))} varied" for stage, targets in tuned.items()]
    try:
        graph = graph_of(base.graph_yaml.encode(), Path("graph.yaml"), study.catalog, is_recorded=True)
    except GraphnavError as error:
        picture = tag("p", f"It cannot be drawn here: {esc(str(error).splitlines()[0])}", class_="note warn")
    else:
        picture = tag("div", svg_of(dataclasses.replace(graph, about=""), notes), class_="scroll drawing")
    return picture + listed(lines, class_="swaps")


def _or(uses: list[str]) -> str:
    return ", ".join(use or "nothing" for use in uses)


def _rivals(base: Case, cases: list[Case]) -> dict[str, list[str]]:
    """Return what each swapped stage is in other cases, an empty text where it is not there."""
    found: dict[str, list[str]] = {}
    for case in cases:
        for stage in case.swapped:
            use = case.uses.get(stage, "")
            uses = found.setdefault(stage, [])
            if use not in uses and use != base.uses.get(stage):
                uses.append(use)
    order = [*base.uses, *(stage for stage in found if stage not in base.uses)]
    return {stage: found[stage] for stage in order if found.get(stage)}


def _tuned(base: Case, cases: list[Case]) -> dict[str, list[str]]:
    """Return what cases set within each stage otherwise than the base, by stage."""
    changed = (t for case in cases for t, value in case.tuned.items() if base.tuned.get(t) != value)
    found: dict[str, list[str]] = {}
    for target in dict.fromkeys(changed):
        found.setdefault(target.partition(".")[0], []).append(target)
    return found
