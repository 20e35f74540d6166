"""Problems of a study that need no graph: nothing to run, or one target set twice."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from graphnav.ablation.plan.variants import Variant
from graphnav.ablation.study import Study, Target, targets_of
from graphnav.errors import Place, Problem, did_you_mean

_OWN = {
    "seed": ("a study's seeds are its worlds", "write seeds: FIRST:END, or --seeds FIRST:END"),
    "record": ("a study records what is small, and of failures everything", "leave it out"),
}
"""Options of ``run:`` that a study decides itself."""


def study_problems(study: Study, variants: Sequence[Variant]) -> Iterator[Problem]:
    """Yield the problems of a study and its variants, each once, at its first place."""
    said = set()
    for problem in _all_problems(study, variants):
        if problem.what not in said:
            said.add(problem.what)
            yield problem


def _all_problems(study: Study, variants: Sequence[Variant]) -> Iterator[Problem]:
    if not study.graphs:
        yield Problem(None, f"the study '{study.name}' has no graphs", "name one: graphnav ablate corridor_ccw ...")
    if not study.seeds:
        yield Problem(None, f"the study '{study.name}' has no seeds", "say which worlds: --seeds 0:50")
    yield from _within(study)
    for text in study.sets:
        yield from _own(text, study.places.get(text))
    for variant in variants:
        yield from _set_twice(study, variant)


def _within(study: Study) -> Iterator[Problem]:
    axes = [axis.name for axis in study.axes]
    unknown = [name for name in study.within if name not in axes]
    for name in unknown:
        hint = did_you_mean(name, axes) or f"axes are {', '.join(axes)}"
        yield Problem(study.places.get(name), f"'within' names '{name}', but the study has no such axis", hint)
    if not study.within or unknown:
        return
    place = study.places.get(study.within[0])
    if study.one_at_a_time:
        what = "'within' needs axes that cross: one at a time, no variant but the base has another condition"
        yield Problem(place, what, "leave out 'within' or 'one_at_a_time'")
    elif len(study.within) == len(axes):
        yield Problem(place, "'within' names every axis, which leaves none to compare", "leave out the one that varies")


def _set_twice(study: Study, variant: Variant) -> Iterator[Problem]:
    who: dict[Target, str] = {target: "'set'" for text in study.sets for target in targets_of(text)}
    for axis, choice in variant.choices.items():
        here: dict[Target, str] = {}
        for text, place in choice.placed_sets:
            yield from _own(text, place)
            for target in targets_of(text):
                if target in who:
                    yield Problem(place, f"axis '{axis}' sets {_shown(target)}, as {who[target]} does", "keep one")
                here[target] = f"axis '{axis}'"
        who |= here


def _own(text: str, place: Place | None) -> Iterator[Problem]:
    for stage, key in targets_of(text):
        if stage == "run" and key in _OWN:
            why, hint = _OWN[key]
            yield Problem(place, f"run.{key} is not for a study to set: {why}", hint)


def _shown(target: Target) -> str:
    return ".".join(filter(None, target))
