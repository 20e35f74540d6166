"""Check the axes of a study, and make plain choices of them."""

from __future__ import annotations

from collections.abc import Iterator

from graphnav.core.errors import Place, Problem
from graphnav.core.graph import Override
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
