"""The variants of a study: all combinations of its axes, or one axis changed at a time."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from graphnav import UserError
from graphnav.core.graph import Override
from graphnav.studies.ablation.study import Axis, Choice, Study

MAX_CASES = 2000
"""The maximum number of graphs times variants."""


@dataclass(frozen=True)
class Variant:
    """A choice of every axis."""

    name: str
    """All its choices, unique in its study."""
    called: str
    """Its name in tables: its choices except conditions, unique among variants under the same conditions."""
    condition: str
    """Its choices of the axes within which variants are compared; empty where there are none."""
    choices: Mapping[str, Choice]
    """By axis."""
    is_base: bool

    @property
    def overrides(self) -> tuple[Override, ...]:
        """The overrides of its choices; what two choices set alike counts once."""
        every = (override for choice in self.choices.values() for override in choice.overrides)
        return tuple({(override.target, repr(override.value)): override for override in every}.values())

    @property
    def labels(self) -> dict[str, str]:
        """Its choice of every axis, as tables call it."""
        return {axis: choice.label for axis, choice in self.choices.items()}


def count_variants(study: Study) -> int:
    """Return how many variants a study has, without making them."""
    sizes = [len(axis.choices) for axis in study.axes]
    return 1 + sum(size - 1 for size in sizes) if study.one_at_a_time else math.prod(sizes)


def expand(study: Study) -> tuple[Variant, ...]:
    """Return the variants of a study, the base first: every axis at its first choice.

    Where variants are compared within conditions they come condition by condition, each with its own base first.

    Raises
    ------
    UserError
        There are more variants than the limit.
    """
    _check_size(study)
    short, rows = _short_labels(study.axes), _rows(study)
    if study.one_at_a_time:
        names = called = _unique(_one_at_a_time_names(study, rows, short))
        conditions = [""] * len(rows)
    else:
        names = _unique(_crossed_names(rows, short))
        called = _names_by(rows, short, [axis.name not in study.within for axis in study.axes])
        conditions = _names_by(rows, short, [axis.name in study.within for axis in study.axes])
    bases: dict[str, str] = {}
    for condition, first in zip(conditions, called, strict=True):
        bases.setdefault(condition, first)
    variants = [
        Variant(name, said, condition, _choices(study, row), is_base=bases[condition] == said)
        for name, said, condition, row in zip(names, called, conditions, rows, strict=True)
    ]
    order = list(bases)
    return tuple(sorted(variants, key=lambda variant: order.index(variant.condition)))


def _choices(study: Study, row: tuple[Choice, ...]) -> dict[str, Choice]:
    return {axis.name: choice for axis, choice in zip(study.axes, row, strict=True)}


def _check_size(study: Study) -> None:
    variants, graphs = count_variants(study), len(study.graphs)
    cases = variants * graphs
    if cases <= MAX_CASES:
        return
    many = f"{variants} variants" if variants < 10**12 else "more than 10^12 variants"
    on = f" on {graphs} graphs" if graphs > 1 else ""
    if study.one_at_a_time:
        what, hint = f"the axes have {many}{on}", "take fewer values"
    else:
        what = f"the axes cross to {many}{on}"
        hint = "vary one axis at a time (--one-at-a-time, or one_at_a_time: true in the study), or take fewer values"
    raise UserError.of(f"{what}: more than {MAX_CASES} rows are too many to compare", hint)


def _rows(study: Study) -> list[tuple[Choice, ...]]:
    if not study.one_at_a_time:
        return list(itertools.product(*(axis.choices for axis in study.axes)))
    base = tuple(axis.choices[0] for axis in study.axes)
    changed = [
        (*base[:number], choice, *base[number + 1 :])
        for number, axis in enumerate(study.axes)
        for choice in axis.choices[1:]
    ]
    return [base, *changed]


def _short_labels(axes: tuple[Axis, ...]) -> list[Mapping[str, str]]:
    """Return the short form of each label in names: itself, with its axis where another axis has the same."""
    times = Counter(choice.label for axis in axes for choice in axis.choices)
    return [
        {c.label: c.label if times[c.label] == 1 else f"{axis.name}={c.label}" for c in axis.choices} for axis in axes
    ]


def _crossed_names(rows: list[tuple[Choice, ...]], short: list[Mapping[str, str]]) -> Iterator[str]:
    for row in rows:
        yield " + ".join(names[choice.label] for names, choice in zip(short, row, strict=True))


def _names_by(rows: list[tuple[Choice, ...]], short: list[Mapping[str, str]], counts: list[bool]) -> list[str]:
    """Return a name for each row made of those choices whose axis counts; rows that have these in common share it."""
    parts = [tuple(choice for choice, does in zip(row, counts, strict=True) if does) for row in rows]
    words = [names for names, does in zip(short, counts, strict=True) if does]
    distinct = list(dict.fromkeys(parts))
    names = dict(zip(distinct, _unique(_crossed_names(distinct, words)), strict=True))
    return [names[part] for part in parts]


def _one_at_a_time_names(study: Study, rows: list[tuple[Choice, ...]], short: list[Mapping[str, str]]) -> Iterator[str]:
    base = rows[0]
    for row in rows:
        changed = [number for number, choice in enumerate(row) if choice is not base[number]]
        if len(study.axes) == 1:
            changed = [0]
        yield short[changed[0]][row[changed[0]].label] if changed else "base"


def _unique(names: Iterator[str]) -> list[str]:
    """Return names with a number behind those that were there before."""
    found: dict[str, None] = {}
    for name in names:
        numbered = (f"{name} ({number})" for number in itertools.count(2))
        found[name if name not in found else next(n for n in numbered if n not in found)] = None
    return list(found)
