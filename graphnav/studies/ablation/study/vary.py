"""Read ``--vary``, check axes, and change those of a study."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

from graphnav import Place, Problem, UserError, did_you_mean
from graphnav.core.graph import Override, Target
from graphnav.core.spec import write_value
from graphnav.studies.ablation.study.study import Axis, Choice

_COLUMNS = ("graph", "variant", "role", "seed", "outcome", "cause", "failure", "frames", "sim_s")
"""Columns that every table of results has beside those of the axes."""
_NAME_HINT = "write what it sets, as in plane: [plane.ica, plane.affine], or a word"


def plain_choice(override: Override, shown: str, place: Place) -> Choice:
    """Return the choice of one value, shown as it was written: ``plane.ica``, ``robot.noise_px=0.50``."""
    target = override.target
    return Choice(shown if target.is_stage else f"{target}={shown}", (override,), place)


def is_plain(axis: Axis) -> bool:
    """Return whether an axis varies the one target that it is called by, as ``plane: [plane.ica, ...]`` does."""
    return all([str(override.target) for override in choice.overrides] == [axis.name] for choice in axis.choices)


def name_problems(name: str, place: Place | None) -> Iterator[Problem]:
    """Yield what is wrong with the name of an axis."""
    if name in _COLUMNS:
        yield Problem(place, f"no axis can be called '{name}': results have a column of that name", "rename it")
    if "=" in name or not name.strip() or not name.isprintable():
        shown = name if name.isprintable() else ascii(name)[1:-1]
        yield Problem(place, f"'{shown}' cannot be an axis's name", _NAME_HINT)


def axis_problems(axis: Axis) -> Iterator[Problem]:
    """Yield what is wrong with the choices of an axis, whatever the graphs are."""
    if not axis.choices:
        yield Problem(axis.place, f"axis '{axis.name}' has no values", "write at least one: [first, second, ...]")
    labels: dict[str, Choice] = {}
    meanings: dict[object, Choice] = {}
    for choice in axis.choices:
        if not choice.label.strip() or not choice.label.isprintable():
            hint = "write one line of letters and digits"
            yield Problem(choice.place, f"{choice.label!a} cannot be the label of a choice in tables", hint)
        if choice.label in labels:
            yield Problem(choice.place, f"axis '{axis.name}' has {choice.label} twice", "keep one", "duplicate")
        elif _meaning(choice) in meanings:
            other = meanings[_meaning(choice)].label
            what = f"axis '{axis.name}': {choice.label} is the same as {other}"
            yield Problem(choice.place, what, "keep one", "duplicate")
        labels.setdefault(choice.label, choice)
        meanings.setdefault(_meaning(choice), choice)


def _meaning(choice: Choice) -> tuple[tuple[str, str], ...]:
    """Return what a choice sets in one form: ``0.5`` and ``0.50`` mean the same."""
    return tuple(sorted((str(override.target), repr(override.value)) for override in choice.overrides))


_HINT = "write AXIS=first,second for a new axis, AXIS+=value to add to one of the study"
_OPENING, _CLOSING = "[{", "]}"
_ADDED = "+"


@dataclass(frozen=True)
class VaryValue:
    """One value: plain YAML data, and how tables show it."""

    value: Any
    shown: str
    place: Place
    override: Override | None = None
    """The same read as ``target=value``, None where it has another form."""

    @property
    def label(self) -> str:
        """The label that it may name among the choices of an axis."""
        return self.value if isinstance(self.value, str) else self.shown


@dataclass(frozen=True)
class Vary:
    """A new axis, another one in place of an axis of the study, or choices to add to one."""

    axis: str
    values: tuple[VaryValue, ...]
    place: Place
    is_added: bool = False

    @property
    def words(self) -> str:
        """``AXIS=first,second``, as ``--vary`` takes it."""
        adds = _ADDED if self.is_added else ""
        return f"{self.axis}{adds}={','.join(value.shown for value in self.values)}"


def vary_of(name: str, values: Iterable[Any], place: Place) -> Vary:
    """Return the change that plain data means; ``AXIS+`` adds to an axis."""
    found = tuple(VaryValue(value, write_value(value), place) for value in values)
    return Vary(name.removesuffix(_ADDED).strip(), found, place, is_added=name.endswith(_ADDED))


def parse_varies(texts: Iterable[str], problems: list[Problem]) -> tuple[Vary, ...]:
    """Return the changes of ``--vary AXIS=first,second`` and ``AXIS+=another``; what is wrong goes to ``problems``."""
    found = []
    for text in texts:
        try:
            found.append(_parse(text, Place(f"--vary {text}")))
        except UserError as error:
            problems += error.problems
    return tuple(found)


def split_values(text: str) -> Iterator[str]:
    """Yield what is between commas that are in no brackets and no quotes."""
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


def _parse(text: str, place: Place) -> Vary:
    name, equals, listed = text.partition("=")
    values = [value.strip() for value in split_values(listed)]
    axis = name.removesuffix(_ADDED).strip()
    if not equals or not axis:
        raise UserError.of("this does not name an axis and its values", _HINT, place)
    if "" in values:
        raise UserError.of(f"axis '{axis}' has no values" if len(values) == 1 else "a value is empty", _HINT, place)
    found = [_value(value, Place(place.file, 0, number)) for number, value in enumerate(values, 1)]
    return Vary(axis, tuple(found), place, is_added=name.endswith(_ADDED))


def _value(text: str, place: Place) -> VaryValue:
    override = None
    with suppress(UserError):
        override = Override.parse(text, place)
    return VaryValue(Override.parse_value(text, place), text, place, override)


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
