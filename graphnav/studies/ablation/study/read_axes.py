"""Read the axes of a study from its file."""

from __future__ import annotations

from collections.abc import Mapping

from graphnav.core.errors import Problem
from graphnav.core.graph import Target
from graphnav.core.spec import Value
from graphnav.studies.ablation.study.axis_checks import axis_problems, name_problems, plain_choice
from graphnav.studies.ablation.study.read_overrides import OverrideReader
from graphnav.studies.ablation.study.source_text import SourceText
from graphnav.studies.ablation.study.study import Axis, Choice
from graphnav.studies.ablation.study.study_keys import Choices, StudyKeys


def axes_of(keys: StudyKeys, source: SourceText, reader: OverrideReader) -> tuple[Axis, ...]:
    """Return the axes under ``vary``: lists of what a target becomes, or mappings of labels to what each sets."""
    axes, problems = [], reader.problems
    for name, choices in keys.vary.items():
        before, place = len(problems), keys.key_place("vary", name)
        problems.extend(name_problems(name, place))
        axis = Axis(name, _choices(name, choices, keys, source, reader), place)
        if len(problems) == before:
            problems.extend(axis_problems(axis))
        axes.append(axis)
    if not axes and not problems:
        hint = "write vary: {plane: [plane.ica, plane.affine]}"
        problems.append(Problem(keys.key_place("vary"), "the study varies nothing", hint))
    return tuple(axes)


def _choices(
    axis: str, choices: Choices, keys: StudyKeys, source: SourceText, reader: OverrideReader
) -> tuple[Choice, ...]:
    if isinstance(choices, Mapping):
        return tuple(
            Choice(label, reader.mapping(settings or {}), keys.key_place("vary", axis, label))
            for label, settings in choices.items()
        )
    place = keys.key_place("vary", axis)
    target = None if place is None or any(name_problems(axis, place)) else reader.target(axis, place)
    return tuple(_plain(target, value, source, reader) for value in choices or ()) if target is not None else ()


def _plain(target: Target, value: Value, source: SourceText, reader: OverrideReader) -> Choice:
    if isinstance(value.data, dict):
        hint = f"name a choice that sets several things: {target}: {{label: {{stage.parameter: value}}}}"
        reader.problems.append(Problem(value.place, f"axis '{target}': a value in a list cannot be a mapping", hint))
    return plain_choice(reader.override(target, value), source.label(value), value.place)
