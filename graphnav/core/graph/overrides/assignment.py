"""Overrides of a known graph: each target stage by stage, checked against the stages of the graph."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from graphnav.core.errors import Place, Problem, did_you_mean
from graphnav.core.graph.node import SET
from graphnav.core.graph.overrides.override import Override
from graphnav.core.spec import RESERVED_STAGES, STAGE_NAME, TIME_KEYS, Entry, Spec

Kind = Literal["swap", "add", "param", "time", "wire", "run"]

_USE = "write family.stage, as 'graphnav stages' lists them"


@dataclass(frozen=True)
class Assignment:
    """A change that an override makes to one stage or to the run."""

    kind: Kind
    stage: str
    key: str
    override: Override

    @property
    def place(self) -> Place:
        """The place of the override."""
        return self.override.place

    @property
    def entry(self) -> Entry:
        """The value as an entry of the graph."""
        return self.override.entry

    @property
    def text(self) -> str:
        """The value of a swap, an added stage or a wire, which is a string."""
        return str(self.override.value)


def assign(overrides: Sequence[Override], spec: Spec, problems: list[Problem]) -> list[Assignment]:
    """Return what overrides change of a graph; what is wrong is added to ``problems``."""
    found: dict[tuple[str, ...], Assignment] = {}
    added = [name for override in overrides if override.target.kind == "add" for name in override.target.stages]
    for override in overrides:
        for assignment in _assignments(override, [*spec.stages, *added], spec.stages, problems):
            target = (assignment.kind, assignment.stage, assignment.key)
            if target in found:
                what = f"this is set twice, first by '{found[target].place}'"
                problems.append(Problem(override.place, what, "keep one", "duplicate"))
            found.setdefault(target, assignment)
    usable = {"", *spec.stages, *(a.stage for a in found.values() if a.kind == "add")}
    return [a for a in found.values() if a.stage in usable]


def _assignments(
    override: Override, stages: Sequence[str], existing: Collection[str], problems: list[Problem]
) -> Iterator[Assignment]:
    """Yield what one override changes; ``stages``: the ``existing`` ones of the graph and those that are added."""
    target = override.target
    if target.kind == "run":
        yield Assignment("run", "", target.key, override)
        return
    for name in target.stages:
        problem = _name_problem(override, name, stages, existing) or _value_problem(override, name)
        if problem is not None:
            problems.append(problem)
        elif target.kind == "setting":
            yield Assignment("time" if target.key in TIME_KEYS else "param", name, target.key, override)
        else:
            kinds: dict[str, Kind] = {"stage": "swap", "add": "add", "wire": "wire"}
            yield Assignment(kinds[target.kind], name, target.key, override)


def _name_problem(override: Override, name: str, stages: Sequence[str], existing: Collection[str]) -> Problem | None:
    """Return what is wrong with the name of a stage, None if nothing is."""
    place = override.place
    if override.target.kind != "add":
        if name in stages:
            return None
        hint = did_you_mean(name, stages) or f"stages are {', '.join(stages)}"
        return Problem(place, f"there is no stage '{name}'", hint, "unknown")
    if name in existing:
        hint = f"choose another name, or swap it with {SET} {name}={override.value}"
        return Problem(place, f"there is a stage '{name}' already", hint, "duplicate")
    if not re.fullmatch(STAGE_NAME, name):
        hint = "use small letters, digits and _, beginning with a letter"
        return Problem(place, f"'{name}' cannot be a stage's name", hint)
    if name in RESERVED_STAGES:
        return Problem(place, f"no stage can be called '{name}'", "choose another name")
    return None


def _value_problem(override: Override, stage: str) -> Problem | None:
    """Return what is wrong with a value that must be a string with characters, of a wire also null; else None."""
    value, target = override.entry.value, override.target
    if target.kind == "setting" or (isinstance(value.data, str) and value.data):
        return None
    if target.kind == "wire":
        if value.data is None:
            return None
        what = f"input '{target.key}' of stage '{stage}' must be wired to stage.port, not {value.kind}"
        return Problem(override.place, what, "write stage.port, or null to disconnect it")
    return Problem(override.place, f"stage '{stage}' must use family.stage, not {value.kind}", _USE)
