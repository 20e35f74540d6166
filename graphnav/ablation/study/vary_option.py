"""``--vary``: replace an axis, add one, or add a choice to one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from graphnav.ablation.study.axis_checks import axis_problems, plain_choice
from graphnav.ablation.study.override_targets import is_plain, is_stage, target_text
from graphnav.ablation.study.study import Axis, Choice
from graphnav.errors import Place, Problem, did_you_mean

_HINT = "write AXIS=first,second for a new axis, AXIS+=value to add to one of the study"
_OPENING, _CLOSING = "[{", "]}"


def varied(axes: Sequence[Axis], options: Sequence[str], problems: list[Problem]) -> tuple[Axis, ...]:
    """Return axes with what ``--vary`` options say; what is wrong is added to ``problems``.

    ``plane=plane.ica,plane.affine`` replaces the axis ``plane`` or adds it behind the others; of an axis whose choices
    have labels it keeps those that it names. ``plane+=plane.mine`` adds a choice to an axis, found by its name or as
    the only one that sets this; to one that sets several things, ``detector+=plane=plane.mine`` says which.
    """
    found = {axis.name: axis for axis in axes}
    replaced: set[str] = set()
    for option in options:
        place = Place(f"--vary {option}")
        name, equals, text = option.partition("=")
        is_added, name = name.endswith("+"), name.removesuffix("+").strip()
        values = [value.strip() for value in split_values(text)]
        before = len(problems)
        if not equals or not name:
            problems.append(Problem(place, "this says no axis and its values", _HINT))
        elif "" in values:
            what = f"axis '{name}' has no values" if len(values) == 1 else "a value is empty"
            problems.append(Problem(place, what, _HINT))
        elif not is_added and name in replaced:
            what = f"axis '{name}' is given twice"
            problems.append(Problem(place, what, f"write --vary {name}=first,second, or --vary {name}+=another"))
        if len(problems) > before:
            continue
        if is_added:
            axis = _added_to(name, values, found, place, problems)
        else:
            replaced.add(name)
            axis = _replaced(name, values, found.get(name), place, problems)
        if len(problems) == before and axis is not None:
            problems += axis_problems(axis)
            found[axis.name] = axis
    return tuple(found.values())


def split_values(text: str) -> Iterator[str]:
    """Yield what stands between commas that are in no brackets and no quotes."""
    depth, quote, start = 0, "", 0
    for number, char in enumerate(text):
        if quote:
            quote = "" if char == quote else quote
        elif char in "\"'" and (depth > 0 or not text[start:number].strip()):
            quote = char
        elif char in _OPENING:
            depth += 1
        elif char in _CLOSING:
            depth -= 1
        elif char == "," and depth <= 0:
            yield text[start:number]
            start = number + 1
    yield text[start:]


def _replaced(name: str, values: Sequence[str], old: Axis | None, place: Place, problems: list[Problem]) -> Axis | None:
    if old is None or is_plain(old):
        return Axis(name, tuple(plain_choice(name, value, place) for value in values), place)
    labels = {choice.label: choice for choice in old.choices}
    for value in values:
        if value not in labels:
            hint = f"it has {', '.join(labels)}; write --vary {name}+={value} to add one"
            problems.append(Problem(place, f"axis '{name}' has no choice '{value}'", hint))
    return replace(old, choices=tuple(labels[value] for value in values if value in labels), place=place)


def _added_to(
    name: str, values: Sequence[str], axes: dict[str, Axis], place: Place, problems: list[Problem]
) -> Axis | None:
    axis = axes.get(name) or _only_one_that_sets(name, axes)
    if axis is None:
        known = f"axes are {', '.join(axes)}" if axes else "the study has none"
        hint = did_you_mean(name, axes) or f"{known}; write --vary {name}=first,second for a new one"
        problems.append(Problem(place, f"there is no axis '{name}' to add to", hint))
        return None
    choices = [_choice(axis, value, place, problems) for value in values]
    return replace(axis, choices=(*axis.choices, *(choice for choice in choices if choice is not None)))


def _choice(axis: Axis, value: str, place: Place, problems: list[Problem]) -> Choice | None:
    if is_plain(axis):
        return plain_choice(axis.name, value, place)
    target, equals, given = value.partition("=")
    if equals:
        return plain_choice(target, given, place)
    targets = _targets(axis)
    if len(targets) == 1:
        return plain_choice(targets[0], value, place)
    what = f"axis '{axis.name}' sets {', '.join(targets)}: it is not clear which of them is to be {value}"
    problems.append(Problem(place, what, f"write --vary {axis.name}+={targets[0]}={value}, or add it to the study"))
    return None


def _only_one_that_sets(target: str, axes: dict[str, Axis]) -> Axis | None:
    found = [axis for axis in axes.values() if _targets(axis) == [target]]
    return found[0] if len(found) == 1 else None


def _targets(axis: Axis) -> list[str]:
    """Return what an axis is about: the stages that it swaps, else all that it sets."""
    targets = list(dict.fromkeys(target_text(text) for choice in axis.choices for text in choice.sets))
    return [target for target in targets if is_stage(target)] or targets
