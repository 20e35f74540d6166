"""Apply changes to the axes of a study: replace an axis, add one, or add a choice to one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from graphnav.core.errors import Problem, UserError, did_you_mean
from graphnav.core.graph import Override, Target
from graphnav.studies.ablation.study.axis_checks import axis_problems, is_plain, name_problems, plain_choice
from graphnav.studies.ablation.study.study import Axis, Choice
from graphnav.studies.ablation.study.vary import Vary, VaryValue


def varied(axes: Sequence[Axis], varies: Sequence[Vary], problems: list[Problem]) -> tuple[Axis, ...]:
    """Return axes with changes; what is wrong is added to ``problems``.

    A change that does not add replaces the axis of its name or comes behind the others; of an axis whose choices have
    labels it keeps those that it names. One that adds finds its axis by name, or as the only one that sets this target;
    where an axis sets several things, ``detector+=plane=plane.mine`` says which.
    """
    found = {axis.name: axis for axis in axes}
    replaced: set[str] = set()
    for vary in varies:
        before = len(problems)
        if not vary.is_added and vary.axis in replaced:
            hint = f"write --vary {vary.axis}=first,second, or --vary {vary.axis}+=another"
            problems.append(Problem(vary.place, f"axis '{vary.axis}' is given twice", hint, "duplicate"))
            continue
        try:
            if vary.is_added:
                axis = _added_to(vary, found)
            else:
                replaced.add(vary.axis)
                axis = _replaced(vary, found.get(vary.axis))
        except UserError as error:
            problems += error.problems
            continue
        problems += axis_problems(axis)
        if len(problems) == before:
            found[axis.name] = axis
    return tuple(found.values())


def _replaced(vary: Vary, old: Axis | None) -> Axis:
    """Return the axis that a change puts in the place of ``old``; raises UserError."""
    if old is None or is_plain(old):
        if wrong := list(name_problems(vary.axis, vary.place)):
            raise UserError(wrong)
        target = Target.parse(vary.axis, vary.place)
        return Axis(vary.axis, tuple(_plain(target, value, vary) for value in vary.values), vary.place)
    labels = {choice.label: choice for choice in old.choices}
    unknown = [value.label for value in vary.values if value.label not in labels]
    if unknown:
        known = f"it has {', '.join(labels)}"
        raise UserError(
            Problem(
                vary.place,
                f"axis '{vary.axis}' has no choice '{label}'",
                f"{known}; write --vary {vary.axis}+={label} to add one",
            )
            for label in unknown
        )
    return replace(old, choices=tuple(labels[value.label] for value in vary.values), place=vary.place)


def _added_to(vary: Vary, axes: dict[str, Axis]) -> Axis:
    """Return an axis with the choices that a change adds; raises UserError."""
    axis = axes.get(vary.axis) or _only_one_that_sets(vary.axis, axes)
    if axis is None:
        known = f"axes are {', '.join(axes)}" if axes else "the study has none"
        hint = did_you_mean(vary.axis, axes) or f"{known}; write --vary {vary.axis}=first,second for a new one"
        raise UserError.of(f"there is no axis '{vary.axis}' to add to", hint, vary.place)
    return replace(axis, choices=(*axis.choices, *(_choice(axis, value, vary) for value in vary.values)))


def _choice(axis: Axis, value: VaryValue, vary: Vary) -> Choice:
    if is_plain(axis):
        return _plain(Target.parse(axis.name, vary.place), value, vary)
    if value.override is not None:
        shown = value.shown.partition("=")[2]
        return plain_choice(value.override, shown, vary.place)
    targets = _targets(axis)
    if len(targets) == 1:
        return _plain(targets[0], value, vary)
    what = (
        f"axis '{axis.name}' sets {', '.join(map(str, targets))}: it is not clear which of them is to be {value.shown}"
    )
    hint = f"write --vary {axis.name}+={targets[0]}={value.shown}, or add it to the study"
    raise UserError(Problem(vary.place, what, hint, "ambiguous"))


def _plain(target: Target, value: VaryValue, vary: Vary) -> Choice:
    return plain_choice(Override(target, value.value, value.place), value.shown, vary.place)


def _only_one_that_sets(target: str, axes: dict[str, Axis]) -> Axis | None:
    found = [axis for axis in axes.values() if list(map(str, _targets(axis))) == [target]]
    return found[0] if len(found) == 1 else None


def _targets(axis: Axis) -> list[Target]:
    """Return what an axis is about: the stages that it swaps, else all that it sets."""
    targets = list(dict.fromkeys(override.target for choice in axis.choices for override in choice.overrides))
    return [target for target in targets if target.is_stage] or targets
