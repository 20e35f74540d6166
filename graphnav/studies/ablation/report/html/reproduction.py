"""How to reproduce the study: its graphs, its commands, the meaning of its numbers."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from markupsafe import Markup

from graphnav import Problem, UserError
from graphnav.core.graph import graph_of
from graphnav.core.render import svg_of
from graphnav.studies.ablation.plan import Case
from graphnav.studies.ablation.report.html.rendering import counted, rendered
from graphnav.studies.ablation.report.html.study_results import StudyResults
from graphnav.studies.ablation.report.legend import INTERVALS, counting, deciding, tests, worlds_of_graphs

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
        first = error.problems[0]
        reason = str(Problem(first.place, first.what))
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


_MEANING = """\
A world is a seed: map, start, textures and noise are drawn from it, and every variant meets the same ones.

Differences are paired: this variant minus the base in the same world. An interval that holds 0 does not say that two
are equal: it says how far apart they may be.

All comparisons of a graph with the base by what decides are one family, under each condition: of tables in which
nothing differs, at most one in twenty calls any variant better or worse.

A baseline lacks what a method claims to need: where a method does not beat it, that is not needed there, or the worlds
test nothing. An oracle sees the truth: it shows what its part
leaves to gain. It is not a bound: what it is part of may fail where another method arrives."""


def reproduce(study: StudyResults) -> Markup:
    """Return the command, the versions, the statistics, and every graph as it ran."""
    plan = study.plan
    versions = ", ".join(f"{name} {version}" for name, version in plan.versions.items())
    own = [case for case in plan.cases if not case.same_as]
    return rendered(
        "reproduction.html",
        command=plan.command,
        origin=[
            ("seeds", worlds_of_graphs(plan)),
            ("versions", versions or "not recorded"),
            ("plugins", ", ".join(plan.plugins) or "none but those that ship"),
        ],
        meaning=_meaning(study),
        notices=[case for case in own if case.notices],
        graphs=[(graph, [case for case in own if case.graph == graph]) for graph in plan.graphs],
    )


def _meaning(study: StudyResults) -> list[str]:
    worlds, *rest = _MEANING.split("\n\n")
    decides = deciding(study.plan, study.comparison.primary, "called better or worse")
    return [worlds, INTERVALS, decides, tests(study.plan), *rest, counting(study.plan, study.metrics), *study.notes]
