"""Drawings of the graphs of a study, with the swapped stages marked."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from markupsafe import Markup

from graphnav.core.errors import UserError
from graphnav.core.graph import graph_of
from graphnav.core.render import svg_of
from graphnav.studies.ablation.plan import Case
from graphnav.studies.ablation.report.html.number_text import counted
from graphnav.studies.ablation.report.html.render import rendered
from graphnav.studies.ablation.report.html.study_results import StudyResults

_FILE = Path("graph.yaml")


@dataclass(frozen=True)
class _Drawing:
    """The base's graph with marked stages, or why it cannot be drawn; for each marked stage what changes."""

    picture: Markup
    error: str
    changes: tuple[tuple[str, str], ...]


def drawings(study: StudyResults) -> Markup:
    """Return the base's graph, once for all graphs that are wired alike, and what each marked stage is swapped for."""
    drawn: dict[_Drawing, list[str]] = {}
    for graph in study.plan.graphs:
        cases = [case for case in study.plan.cases if case.graph == graph]
        drawn.setdefault(_drawing(study, cases), []).append(graph)
    return rendered("drawings.html", drawings=drawn.items())


def _drawing(study: StudyResults, cases: list[Case]) -> _Drawing:
    base = next(case for case in cases if case.is_base)
    rivals = _rivals(base, cases)
    tuned = _tuned(base, cases)
    notes = {stage: counted(sum(map(bool, uses)), "rival") for stage, uses in rivals.items() if stage in base.uses}
    notes |= {stage: "varied" for stage in tuned if stage in base.uses and stage not in notes}
    changes = [
        (stage, f"{base.uses.get(stage, 'not in the base')}; swapped for {_or(uses)}") for stage, uses in rivals.items()
    ]
    changes += [(stage, f"{', '.join(targets)} varied") for stage, targets in tuned.items()]
    picture, reason = Markup(""), ""
    try:
        plugins = [Path(plugin).name for plugin in study.plan.plugins]  # those that may run are in the catalog
        graph = study.graphs.get(base.folder) or graph_of(
            base.graph_yaml.encode(), _FILE, study.catalog, replaced=plugins, is_record=True
        )
    except UserError as error:
        reason = str(replace(error.problems[0], hint=""))
    else:
        picture = svg_of(replace(graph, about="", path=_FILE), notes)
    return _Drawing(picture, reason, tuple(changes))


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
    """Return the parameters, wires and options by stage (or ``run``) that other cases set and the base does not."""
    found: dict[str, dict[str, None]] = {}
    for override in (override for case in cases for override in case.overrides):
        if not override.target.is_stage and override not in base.overrides:
            for target in override.target.each:
                found.setdefault(next(iter(target.stages), target.kind), {})[str(target)] = None
    return {stage: list(targets) for stage, targets in found.items()}
