"""Read overrides from the text of an option: ``KEY=VALUE``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from graphnav.core.errors import Place, Problem, UserError
from graphnav.core.graph.overrides.override import Override
from graphnav.core.graph.overrides.target import HINT, Target
from graphnav.core.graph.wiring.settings import SET
from graphnav.core.spec import parse_scalar, parse_yaml

_READ_AS_YAML = ("[", "{", '"', "'")


def parse_overrides(texts: Iterable[str], problems: list[Problem]) -> tuple[Override, ...]:
    """Return the overrides of ``--set`` options, each placed at its text; what is wrong is added to ``problems``."""
    found = []
    for text in texts:
        try:
            found.append(parse_override(text))
        except UserError as error:
            problems += error.problems
    return tuple(found)


def parse_override(text: str, place: Place | None = None) -> Override:
    """Return what ``target=value`` says; without a place that of ``--set`` with this text.

    Raises
    ------
    UserError
        It has another form, or the value is not YAML.
    """
    place = place or Place(f"{SET} {text}")
    target, equals, value = text.partition("=")
    if not equals:
        raise UserError.of("this sets nothing", HINT, place)
    return Override(Target.parse(target, place), parse_value(value, place), place)


def parse_value(text: str, place: Place) -> Any:
    """Return what a value means: brackets and quotes are read as YAML, all else as a plain scalar.

    Raises
    ------
    UserError
        It is not YAML.
    """
    if not text.startswith(_READ_AS_YAML):
        return parse_scalar(text)
    try:
        value, problems = parse_yaml(text.encode("utf-8", "replace"), "")
    except UserError as error:
        problems = error.problems
    if problems:
        raise UserError([Problem(place, problem.what, problem.hint, problem.kind) for problem in problems])
    return value.plain()
