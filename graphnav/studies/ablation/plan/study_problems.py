"""Check what a study says without its graphs, and the metrics that it names."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from graphnav import Metric, Place, Problem, Stage, UserError, did_you_mean
from graphnav.core.graph import Override, Target
from graphnav.core.stage import FormerNames, metrics_of
from graphnav.studies.ablation.plan.variants import Variant
from graphnav.studies.ablation.study import MetricExpression, Study

Classes = Mapping[str, Sequence[type[Stage]]]
"""The classes of the stages of all cases, by their names in the graphs."""


def checked_metrics(study: Study, classes: Classes, problems: list[Problem]) -> tuple[str, ...]:
    """Return the columns of a study's table; what is wrong is added to ``problems``."""
    columns: list[str] = []
    for text in study.metrics:
        place = study.places.get(text)
        try:
            column = MetricExpression.parse(text)
        except UserError as error:
            problems += [Problem(place, problem.what, problem.hint) for problem in error.problems]
            continue
        wrong = [*_unknown(column, place, classes), *_without_reference(study, column, place, classes)]
        problems += wrong
        if not wrong:
            columns.append(column.text)
    return tuple(dict.fromkeys(columns))


def declared_metrics(classes: Classes) -> dict[str, Metric]:
    """Return the declared metrics by ``stage.metric``; of a stage that is swapped, the first class counts."""
    found: dict[str, Metric] = {}
    for stage, each in classes.items():
        for cls in each:
            for name, metric in metrics_of(cls).items():
                found.setdefault(f"{stage}.{name}", metric)
    return found


def _without_reference(
    study: Study, column: MetricExpression, place: Place | None, classes: Classes
) -> Iterator[Problem]:
    declared = declared_metrics(classes)
    for operand in column.operands:
        metric = declared.get(operand)
        if metric is not None and metric.relative_to and not study.reference:
            what = f"'{operand}' is relative to a reference variant, and the study names none"
            yield Problem(place, what, "write reference: VARIANT, or --reference VARIANT")


def _unknown(column: MetricExpression, place: Place | None, classes: Classes) -> Iterator[Problem]:
    declared = declared_metrics(classes)
    scored = [name for name, found in classes.items() if any(metrics_of(cls) for cls in found)]
    stages = f"stages that report metrics are {', '.join(scored)}" if scored else "no stage reports any: add a score"
    for operand in column.operands:
        stage, _, metric = operand.partition(".")
        if stage not in classes:
            yield Problem(place, f"'{operand}': no graph has a stage '{stage}'", did_you_mean(stage, scored) or stages)
        elif stage not in scored:
            yield Problem(place, f"'{operand}': stage '{stage}' reports no metrics", stages)
        elif operand not in declared:
            known = [name for cls in classes[stage] for name in metrics_of(cls)]
            near = did_you_mean(metric, known, {**FormerNames.METRICS, **FormerNames.REPLACED_METRICS})
            hint = near or f"its metrics are {', '.join(dict.fromkeys(known))}"
            yield Problem(place, f"'{operand}': stage '{stage}' has no metric '{metric}'", hint)


_MAX_NAMED = 20
"""Variants that a hint lists."""

_OWN = {
    "seed": ("a study's seeds are its worlds", "write seeds: FIRST:END, or --seeds FIRST:END"),
}
"""Options of ``run:`` that a study decides itself."""
_OF_AXES = {
    "record": (
        "all logs of a study keep the same",
        "give it for all runs: --set run.record=replayable, or set: [run.record=replayable] in the study's file",
    )
}
"""Options of ``run:`` that no axis may have."""


def study_problems(study: Study, variants: Sequence[Variant]) -> Iterator[Problem]:
    """Yield the problems of a study and its variants, each once, at its first place."""
    found: dict[object, Problem] = {}
    for about, problem in _all_problems(study, variants):
        found.setdefault(about, problem)
    yield from found.values()


def _all_problems(study: Study, variants: Sequence[Variant]) -> Iterator[tuple[object, Problem]]:
    """Yield what each problem is about, and the problem."""
    if not study.graphs:
        hint = "name one: graphnav ablate corridor_ccw ..."
        yield "graphs", Problem(None, f"the study '{study.name}' has no graphs", hint)
    if not study.seeds:
        yield "seeds", Problem(None, f"the study '{study.name}' has no seeds", "specify the worlds: --seeds 0:50")
    yield from ((problem, problem) for problem in _within(study))
    yield from ((problem, problem) for problem in _reference(study, variants))
    for override in study.overrides:
        yield from _own(override, _OWN)
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


def _reference(study: Study, variants: Sequence[Variant]) -> Iterator[Problem]:
    names = list(dict.fromkeys(variant.called for variant in variants))
    if study.reference and study.reference not in names:
        what = f"the reference is '{study.reference}', but the study has no such variant"
        hint = did_you_mean(study.reference, names) or f"its variants are {', '.join(names[:_MAX_NAMED])}"
        yield Problem(study.places.get(study.reference), what, hint)


def _set_twice(study: Study, variant: Variant) -> Iterator[tuple[object, Problem]]:
    """Yield what an axis sets, and 'set' or another axis, too; an oracle replaces a stage that 'set' put in."""
    who = {
        target: ("'set'", override.value)
        for override in study.overrides
        if study.decomposition is None or not override.target.is_stage
        for target in override.target.each
    }
    for axis, choice in variant.choices.items():
        here: dict[Target, tuple[str, object]] = {}
        for override in choice.overrides:
            yield from _own(override, _OWN | _OF_AXES)
            for target in override.target.each:
                setter, value = who.get(target, ("", None))
                if setter and (study.decomposition is None or value != override.value):
                    what = f"axis '{axis}' sets {target}, as {setter} does"
                    yield (axis, target, setter), Problem(override.place, what, "keep one", "duplicate")
                here[target] = f"axis '{axis}'", override.value
        who |= here


def _own(override: Override, refused: Mapping[str, tuple[str, str]]) -> Iterator[tuple[object, Problem]]:
    target = override.target
    if target.kind == "run" and target.key in refused:
        who = "a study" if target.key in _OWN else "an axis"
        why, hint = refused[target.key]
        yield target, Problem(override.place, f"{target} is not for {who} to set: {why}", hint)
