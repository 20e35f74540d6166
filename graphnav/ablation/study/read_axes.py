"""Read the axes of a study from its file."""

from __future__ import annotations

from collections.abc import Mapping

from graphnav.ablation.study.axis_checks import axis_problems, plain_choice
from graphnav.ablation.study.set_texts import set_texts
from graphnav.ablation.study.source_text import SourceText
from graphnav.ablation.study.study import Axis, Choice
from graphnav.ablation.study.study_keys import Choices, Settings, StudyKeys
from graphnav.errors import Place, Problem
from graphnav.spec import Value


def axes_of(keys: StudyKeys, source: SourceText, problems: list[Problem]) -> tuple[Axis, ...]:
    """Return the axes under ``vary``: lists of what a target becomes, or mappings of labels to what each sets."""
    axes = []
    for name, choices in keys.vary.items():
        before = len(problems)
        axis = Axis(name, _choices(name, choices, keys, source, problems), keys.key_place("vary", name))
        if len(problems) == before:
            problems += axis_problems(axis)
        axes.append(axis)
    if not axes and not problems:
        hint = "write vary: {plane: [plane.ica, plane.affine]}"
        problems.append(Problem(keys.key_place("vary"), "the study varies nothing", hint))
    return tuple(axes)


def _choices(
    axis: str, choices: Choices, keys: StudyKeys, source: SourceText, problems: list[Problem]
) -> tuple[Choice, ...]:
    if isinstance(choices, Mapping):
        return tuple(
            _labelled(label, settings or {}, keys.key_place("vary", axis, label), source, problems)
            for label, settings in choices.items()
        )
    return tuple(_plain(axis, value, source, problems) for value in choices or ())


def _plain(axis: str, value: Value, source: SourceText, problems: list[Problem]) -> Choice:
    if isinstance(value.data, dict):
        hint = f"name a choice that sets several things: {axis}: {{label: {{stage.parameter: value}}}}"
        problems.append(Problem(value.place, f"axis '{axis}': a value in a list cannot be a mapping", hint))
    return plain_choice(axis, source.text(value), value.place, source.label(value))


def _labelled(
    label: str, settings: Settings, place: Place | None, source: SourceText, problems: list[Problem]
) -> Choice:
    sets = set_texts(settings, source, problems)
    return Choice(label, tuple(sets), tuple(sets.values()), place)
