"""How to reproduce the study, and what its numbers mean."""

from __future__ import annotations

from markupsafe import Markup

from graphnav.ablation.report.html.render import rendered
from graphnav.ablation.report.html.study_results import StudyResults
from graphnav.ablation.report.legend import INTERVALS, counting, worlds_of_graphs
from graphnav.ablation.results import MIN_WORLDS

_MEANING = """\
A world is a seed: map, start, textures and noise are drawn from it, and every variant meets the same ones.

Differences are paired: this variant minus the base in the same world. A variant is called better or worse only where
the interval of that difference leaves out 0, over {min_n} worlds or more. An interval that holds 0 does not say that
two are equal: it says how far apart they may be.

Of {n} comparisons with the base, about {chance} leave out 0 by chance alone.

A baseline lacks what a method claims to need: where a method does not beat it, that is not needed there, or the worlds
test nothing. An oracle sees the truth: it bounds what methods can reach."""


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
    n = sum(1 for row in study.comparison.rows if row.differences and not row.case.same_as)
    own = _MEANING.format(min_n=MIN_WORLDS, n=n, chance=f"{0.05 * n:.1f}").split("\n\n")
    return [own[0], INTERVALS, *own[1:], counting(study.plan, study.metrics), *study.notes]
