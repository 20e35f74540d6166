"""How to reproduce the study, and what its numbers mean."""

from __future__ import annotations

from markupsafe import Markup

from graphnav.studies.ablation.report.html.render import rendered
from graphnav.studies.ablation.report.html.study_results import StudyResults
from graphnav.studies.ablation.report.legend import INTERVALS, counting, deciding, tests, worlds_of_graphs

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
