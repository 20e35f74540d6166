"""An override of a graph: target, value and place, also from the text of an option, ``KEY=VALUE``."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from graphnav.core.errors import Place, Problem, UserError
from graphnav.core.graph.node import SET
from graphnav.core.graph.overrides.target import HINT, Target
from graphnav.core.spec import Entry, Value, parse_scalar, parse_yaml, write_value

_READ_AS_YAML = ("[", "{", '"', "'")


@dataclass(frozen=True)
class Override:
    """A value that replaces what a graph says of a target; equal where target and value are, wherever written."""

    target: Target
    value: Any = field(hash=False)
    """Plain YAML data: a scalar, a list or a mapping."""
    place: Place = field(compare=False)
    folder: Path | None = field(default=None, compare=False)
    """Where paths in the value are looked for before the working folder."""

    @property
    def words(self) -> str:
        """``target=value``, as ``--set`` takes it."""
        return f"{self.target}={write_value(self.value)}"

    @property
    def note(self) -> str:
        """The option that gives the same; resolved graphs and notices say it, wherever the override was written."""
        return f"{SET} {self.words}"

    @property
    def entry(self) -> Entry:
        """The value as an entry of the graph."""
        return Entry(self.place, _placed(self.value, self.place), is_override=True)

    @staticmethod
    def parse(text: str, place: Place | None = None) -> Override:
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
        return Override(Target.parse(target, place), Override.parse_value(value, place), place)

    @staticmethod
    def parse_all(texts: Iterable[str], problems: list[Problem]) -> tuple[Override, ...]:
        """Return the overrides of ``--set`` options, each placed at its text; add what is wrong to ``problems``."""
        found = []
        for text in texts:
            try:
                found.append(Override.parse(text))
            except UserError as error:
                problems += error.problems
        return tuple(found)

    @staticmethod
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

    @staticmethod
    def without_replaced(overrides: Iterable[Override], later: Iterable[Override]) -> tuple[Override, ...]:
        """Return overrides without their swaps of stages that later ones swap, too."""
        swapped = {stage for override in later if override.target.kind == "stage" for stage in override.target.stages}
        kept = []
        for override in overrides:
            stages = override.target.stages
            if override.target.kind == "stage" and swapped.intersection(stages):
                stages = tuple(stage for stage in stages if stage not in swapped)
                if stages:
                    kept.append(replace(override, target=Target("stage", stages)))
            else:
                kept.append(override)
        return tuple(kept)


def _placed(value: Any, place: Place) -> Value:
    """Return plain data as a value whose parts all have one place."""
    if isinstance(value, dict):
        return Value({key: Entry(place, _placed(item, place)) for key, item in value.items()}, place)
    return Value([_placed(item, place) for item in value] if isinstance(value, list) else value, place)
