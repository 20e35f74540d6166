"""How to reproduce the study, and what its numbers mean."""

from __future__ import annotations

from graphnav.ablation.report.html.markup import Html, details, esc, listed, tag
from graphnav.ablation.report.html.study_results import StudyResults
from graphnav.ablation.report.legend import INTERVALS, counting, seeds_text
from graphnav.ablation.results import MIN_WORLDS

_MEANING = """\
A world is a seed: map, start, textures and noise are drawn from it, and every variant meets the same ones.

Differences are paired: this variant minus the base in the same world. A variant is called better or worse only where
the interval of that difference leaves out 0, over {least} worlds or more. An interval that holds 0 does not say that
two are equal: it says how far apart they may be.

Of {n} comparisons with the base, about {chance} leave out 0 by chance alone.

A baseline lacks what a method claims to need: where a method does not beat it, that is not needed there, or the worlds
test nothing. An oracle sees the truth: it bounds what methods can reach."""


def reproduce(study: StudyResults) -> Html:
    """Return the command, the versions, the statistics, and every graph as it ran."""
    plan = study.plan
    versions = ", ".join(f"{name} {version}" for name, version in plan.versions.items())
    facts = [
        ("seeds", seeds_text(plan.seeds)),
        ("versions", versions or "not recorded"),
        ("plugins", ", ".join(plan.plugins) or "none beside those that ship"),
    ]
    drawn = [tag("div", tag("dt", esc(name)), tag("dd", esc(text))) for name, text in facts]
    return "".join(
        [
            tag("pre", esc(plan.command), class_="command"),
            tag("dl", *drawn, class_="facts"),
            _meaning(study),
            _notices(study),
            *(_graph(study, graph) for graph in plan.graphs),
        ]
    )


def _meaning(study: StudyResults) -> Html:
    n = sum(1 for row in study.comparison.rows if row.differences and not row.case.same_as)
    own = _MEANING.format(least=MIN_WORLDS, n=n, chance=f"{0.05 * n:.1f}").split("\n\n")
    said = [own[0], INTERVALS, *own[1:], counting(study.plan, study.metrics)]
    return tag("h3", "What the intervals mean") + listed([esc(text) for text in said], class_="meaning")


def _notices(study: StudyResults) -> Html:
    found = [
        f"{tag('b', esc(case.variant))} on {esc(case.graph)}: {esc('; '.join(case.notices))}"
        for case in study.plan.cases
        if case.notices and not case.same_as
    ]
    return details("What the swaps rewired, pruned and set to defaults", listed(found)) if found else ""


def _graph(study: StudyResults, graph: str) -> Html:
    cases = [case for case in study.plan.cases if case.graph == graph and not case.same_as]
    inner = [details(esc(case.variant), tag("pre", esc(case.graph_yaml))) for case in cases]
    return details(f"{esc(graph)}: the {len(cases)} graphs as they ran", *inner)
