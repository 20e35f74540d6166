"""The targets of a ``--set`` text, before any graph is known."""

from __future__ import annotations

from collections.abc import Iterable

from graphnav.ablation.study.study import Axis, Choice
from graphnav.errors import Place, UserError
from graphnav.graph.overrides.assignment import ADD, Assignment

Target = tuple[str, str]
"""A stage (or ``run``) and what of it: a parameter, ``in.port``, or nothing for the whole stage."""


def target_text(text: str) -> str:
    """Return what stands before the first ``=``."""
    return text.partition("=")[0]


def is_stage(target: str) -> bool:
    """Return whether a target is a whole stage, or several."""
    return "." not in target


def targets_of(text: str) -> tuple[Target, ...]:
    """Return all that a text changes: ``plane,twin.rule=otsu`` is the rule of two stages.

    The name of a stage that is added ends in ``+``: what adds it leaves another text free to swap it.
    """
    names, _, key = target_text(text).partition(".")
    added = ADD if names.endswith(ADD) else ""
    return tuple((name + added, key) for name in names.removesuffix(ADD).split(","))


def swaps_of(sets: Iterable[str]) -> dict[str, str]:
    """Return which stages are swapped or added, and for what."""
    return {
        stage.removesuffix(ADD): text.partition("=")[2] for text in sets for stage, key in targets_of(text) if not key
    }


def settings_of(sets: Iterable[str]) -> dict[str, str]:
    """Return what is set within stages: each value as it is written, by ``stage.parameter`` or ``stage.in.port``."""
    return {f"{stage}.{key}": text.partition("=")[2] for text in sets for stage, key in targets_of(text) if key}


def is_plain(axis: Axis) -> bool:
    """Return whether an axis varies the one target that it is called by, as ``plane: [plane.ica, ...]`` does."""
    return all(len(choice.sets) == 1 and target_text(choice.sets[0]) == axis.name for choice in axis.choices)


def meaning(choice: Choice) -> tuple[tuple[str, str], ...]:
    """Return what a choice sets in one form: ``0.5`` and ``0.50`` mean the same."""
    return tuple(sorted((target_text(text), repr(_value(text))) for text in choice.sets))


def _value(text: str) -> object:
    """Return the value of a text; one that is no YAML stands for itself until it is read with its graph."""
    value = text.partition("=")[2]
    try:
        return Assignment("param", "", "", value, Place("")).entry.value.plain()
    except UserError:
        return value
