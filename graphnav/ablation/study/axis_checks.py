"""Check the axes of a study, and make plain choices of them."""

from __future__ import annotations

from collections.abc import Iterable

from graphnav.ablation.study.override_targets import is_stage, meaning
from graphnav.ablation.study.study import Axis, Choice
from graphnav.errors import Place, Problem

_COLUMNS = ("graph", "variant", "seed", "outcome", "failure", "frames", "sim_s")
"""Columns that every table of results has beside those of the axes."""


def plain_choice(target: str, text: str, place: Place, label: str = "") -> Choice:
    """Return the choice of one value; a stage is called by what it is swapped for, all else by ``target=value``."""
    shown = label or text
    return Choice(shown if is_stage(target) else f"{target}={shown}", (f"{target}={text}",), (place,), place)


def axis_problems(axis: Axis) -> Iterable[Problem]:
    """Yield what is wrong with an axis, whatever the graphs are."""
    if axis.name in _COLUMNS:
        yield Problem(
            axis.place, f"no axis can be called '{axis.name}': results have a column of that name", "rename it"
        )
    if "=" in axis.name or not axis.name.strip() or not axis.name.isprintable():
        what = f"'{axis.name if axis.name.isprintable() else ascii(axis.name)[1:-1]}' cannot be an axis's name"
        yield Problem(axis.place, what, "write what it sets, as in plane: [plane.ica, plane.affine], or a word")
    if not axis.choices:
        yield Problem(axis.place, f"axis '{axis.name}' has no values", "write at least one: [first, second, ...]")
    labels: dict[str, Choice] = {}
    meanings: dict[object, Choice] = {}
    for choice in axis.choices:
        if not choice.label.strip() or not choice.label.isprintable():
            hint = "write one line of letters and digits"
            yield Problem(choice.place, f"{choice.label!a} cannot be what tables call a choice", hint)
        if choice.label in labels:
            yield Problem(choice.place, f"axis '{axis.name}' has {choice.label} twice", "keep one")
        elif meaning(choice) in meanings:
            other = meanings[meaning(choice)].label
            yield Problem(choice.place, f"axis '{axis.name}': {choice.label} is the same as {other}", "keep one")
        labels.setdefault(choice.label, choice)
        meanings.setdefault(meaning(choice), choice)
